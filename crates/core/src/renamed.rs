//! Columns of a table that another program wrote: which of them hold what a points file calls by its own names
//! (docs/design/contracts.md §2, `[columns]`).

use crate::input::Table;

/// A column of a points file and the columns of the table whose numbers it is the sum of.
#[derive(Clone, Debug, PartialEq)]
pub struct Renamed {
    /// Name in a points file, with its unit.
    pub name: String,
    /// Columns of the table, at least one.
    pub sum_of: Vec<Part>,
}

/// A column of the table and what its numbers are multiplied with.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name in the table.
    pub column: String,
    /// For another unit or sense; 1 where only the name is given.
    pub factor: f64,
}

/// Between factor and name: `0.001 * deviation_um`.
const TIMES: &str = " * ";

impl Part {
    /// `NAME`, or `FACTOR * NAME`. A name that holds an asterisk itself is a name where no number precedes it.
    fn parse(text: &str) -> Self {
        let scaled = text.split_once(TIMES).and_then(|(factor, column)| {
            let factor = factor.trim().parse().ok().filter(|factor: &f64| factor.is_finite())?;
            Some(Self { column: column.trim().into(), factor })
        });
        scaled.unwrap_or_else(|| Self { column: text.into(), factor: 1.0 })
    }
}

/// Reads `[columns]` of a setup file; empty without one.
pub(crate) fn read_columns(root: &Table<'_>) -> Option<Vec<Renamed>> {
    let Some(table) = root.optional_table("columns") else { return Some(Vec::new()) };
    let names = table.keys();
    let read = |name: &String| {
        let sum_of = table.strings(name)?;
        if sum_of.is_empty() {
            let allowed =
                "the name of a column, or the names of those to add: [\"target\", \"0.001 * deviation_um\"]";
            table.problem(name, "= []", allowed, "Columns that are not named are not read.");
            return None;
        }
        Some(Renamed { name: name.clone(), sum_of: sum_of.iter().map(|text| Part::parse(text)).collect() })
    };
    let columns: Vec<Option<Renamed>> = names.iter().map(read).collect();
    columns.into_iter().collect()
}
