//! What text and page of a named method share: numbers in their units, heads of tables.

use crate::number::{MISSING, plain, signed, unit_on_screen, value_and_u};
use trunnion_results::{Cell, Column, FoundValue, Table};

/// Heads of the table of values.
pub const VALUE_HEADS: [&str; 4] = ["value", "", "u", "remark"];

/// Name, value, standard uncertainty, remark.
pub fn value_row(found: &FoundValue) -> Vec<String> {
    let (value, u) = value_and_u(found.value, found.u, &found.unit);
    vec![found.name.clone(), value, u, found.note.clone()]
}

/// Heads with units.
pub fn heads(table: &Table) -> Vec<String> {
    let head = |column: &Column| {
        column.unit.as_ref().map_or_else(
            || column.name.clone(),
            |unit| match unit_on_screen(unit) {
                symbol if symbol.is_empty() => column.name.clone(),
                symbol => format!("{} ({symbol})", column.name),
            },
        )
    };
    table.columns.iter().map(head).collect()
}

/// Cells as text; numbers in the unit of their column.
pub fn cells(table: &Table, row: &[Cell]) -> Vec<String> {
    let text = |(cell, column): (&Cell, &Column)| match cell {
        Cell::Text(text) => text.clone(),
        // Places are reported to a tenth, however far out.
        Cell::Number(mm) if column.unit.as_deref() == Some("mm") => {
            signed(*mm, 1).trim_start_matches('+').into()
        }
        Cell::Number(number) => plain(*number),
        Cell::Missing => MISSING.into(),
    };
    row.iter().zip(&table.columns).map(text).collect()
}

/// Columns that hold numbers.
pub fn numeric(table: &Table) -> Vec<usize> {
    let is_number = |j: &usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(*j)).peekable();
        cells.peek().is_some() && cells.all(|cell| !matches!(cell, Cell::Text(_)))
    };
    (0..table.columns.len()).filter(is_number).collect()
}
