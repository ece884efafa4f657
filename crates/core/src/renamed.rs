//! Columns of a table that another program wrote: which of them hold what a points file calls by its own names
//! (docs/design/contracts.md §2, `[columns]`).

use crate::input::Table;

/// A column of a points file and the columns of the table whose numbers it is the sum of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Renamed {
    /// Name in a points file, with its unit.
    pub name: String,
    /// Names in the table, at least one.
    pub sum_of: Vec<String>,
}

/// Reads `[columns]` of a setup file; empty without one.
pub(crate) fn read_columns(root: &Table<'_>) -> Option<Vec<Renamed>> {
    let Some(table) = root.optional_table("columns") else { return Some(Vec::new()) };
    let names = table.keys();
    let read = |name: &String| {
        let sum_of = table.strings(name)?;
        if sum_of.is_empty() {
            let advice = "Columns that are not named are not read.";
            table.problem(name, "= []", "the name of a column, or the names of those to add", advice);
            return None;
        }
        Some(Renamed { name: name.clone(), sum_of })
    };
    let columns: Vec<Option<Renamed>> = names.iter().map(read).collect();
    columns.into_iter().collect()
}
