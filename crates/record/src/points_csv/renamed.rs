//! A table of another program read as a points file: its columns under our names (docs/design/contracts.md §2, `[columns]`).

use super::notes::Notes;
use crate::rows::Cell;
use trunnion_core::names::allowed;
use trunnion_core::{Renamed, Setup};

/// How the cells of a row become those of a points file.
pub(super) enum Renaming {
    /// It is a points file.
    None,
    /// For each column of the points file where its parts are in a row of the table.
    To(Vec<Source>),
}

/// Where a column comes from.
pub(super) enum Source {
    /// The name of the only setup.
    Setup(String),
    /// Sum of the cells in these places.
    Sum(Vec<usize>),
}

impl Renaming {
    /// From the header of the table, and the header as a points file has it. Columns that are not named are passed over.
    pub fn of(
        notes: &mut Notes<'_>,
        line: usize,
        header: Vec<Cell>,
        columns: &[Renamed],
        setups: Option<&[Setup]>,
    ) -> (Self, Vec<Cell>) {
        if columns.is_empty() {
            return (Self::None, header);
        }
        let place = |name: &String| header.iter().position(|(_, cell)| cell == name);
        let (mut sources, mut renamed) = (Vec::new(), Vec::new());
        for Renamed { name, sum_of } in columns {
            let places: Vec<usize> = sum_of.iter().filter_map(place).collect();
            for missing in sum_of.iter().filter(|name| place(name).is_none()) {
                let names = allowed(missing, header.iter().map(|(_, cell)| cell.as_str()));
                let found = format!("column \"{missing}\" of [columns] is missing");
                notes.add(line, 1, &found, &names, "Name a column of this table in the setup file.");
            }
            renamed.push((places.first().map_or(1, |&first| header[first].0), name.clone()));
            sources.push(Source::Sum(places));
        }
        // A table of one setup has no reason to name it in each row.
        if let (Some([setup]), false) = (setups, columns.iter().any(|column| column.name == SETUP)) {
            sources.push(Source::Setup(setup.name.clone()));
            renamed.push((1, SETUP.into()));
        }
        (Self::To(sources), renamed)
    }

    /// The cells of a row as a points file has them.
    pub fn row(&self, cells: Vec<Cell>) -> Vec<Cell> {
        match self {
            Self::None => cells,
            Self::To(sources) => sources.iter().map(|source| source.cell(&cells)).collect(),
        }
    }
}

const SETUP: &str = "setup";

impl Source {
    fn cell(&self, cells: &[Cell]) -> Cell {
        let parts: Vec<&Cell> = match self {
            Self::Setup(name) => return (1, name.clone()),
            Self::Sum(places) => places.iter().map(|&place| &cells[place]).collect(),
        };
        let numbers: Vec<Option<f64>> = parts.iter().map(|(_, text)| text.parse().ok()).collect();
        match (&parts[..], numbers.iter().position(Option::is_none)) {
            ([], _) => (1, String::new()),
            ([only], _) => (*only).clone(),
            // What is no number is reported where it stands.
            (_, Some(wrong)) => parts[wrong].clone(),
            (parts, None) => (parts[0].0, numbers.iter().flatten().sum::<f64>().to_string()),
        }
    }
}
