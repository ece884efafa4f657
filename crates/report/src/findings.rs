//! What text and page of a named method share: numbers in their units, heads of tables.

use crate::number::{MISSING, plain, signed, unit_on_screen, value_and_u};
use trunnion_effects::Unit;
use trunnion_methods::findings::{Cell, Column, FoundTable, FoundValue};

/// Heads of the table of values.
pub const VALUE_HEADS: [&str; 4] = ["value", "", "u", "remark"];

/// Name, value, standard uncertainty, remark.
pub fn value_row(found: &FoundValue) -> Vec<String> {
    let scaled = |number: f64| number * found.unit.per_inside;
    let (value, u) = value_and_u(Some(scaled(found.value)), found.u.map(scaled), found.unit.symbol);
    vec![found.name.clone(), value, u, found.note.clone()]
}

/// Heads with units.
pub fn heads(table: &FoundTable) -> Vec<String> {
    let head = |column: &Column| {
        column.unit.map_or_else(
            || column.name.clone(),
            |unit| match unit_on_screen(unit.symbol) {
                symbol if symbol.is_empty() => column.name.clone(),
                symbol => format!("{} ({symbol})", column.name),
            },
        )
    };
    table.columns.iter().map(head).collect()
}

/// Cells as text; numbers in the unit of their column.
pub fn cells(table: &FoundTable, row: &[Cell]) -> Vec<String> {
    let text = |(cell, column): (&Cell, &Column)| match cell {
        Cell::Text(text) => text.clone(),
        // Places are told to a tenth, however far out.
        Cell::Number(mm) if column.unit == Some(Unit::MM) => signed(*mm, 1).trim_start_matches('+').into(),
        Cell::Number(number) => plain(number * column.unit.map_or(1.0, |unit| unit.per_inside)),
        Cell::Missing => MISSING.into(),
    };
    row.iter().zip(&table.columns).map(text).collect()
}

/// Columns that hold numbers.
pub fn numeric(table: &FoundTable) -> Vec<usize> {
    let is_number = |j: &usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(*j)).peekable();
        cells.peek().is_some() && cells.all(|cell| !matches!(cell, Cell::Text(_)))
    };
    (0..table.columns.len()).filter(is_number).collect()
}
