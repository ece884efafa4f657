//! A table of another program read as a points file: its columns under our names (docs/design/contracts.md §2, `[columns]`).

use super::notes::Notes;
use crate::rows::Cell;
use trunnion_core::names::allowed;
use trunnion_core::{Part, Renamed, Setup};

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
    /// Sum of the cells in these places, each with its factor.
    Sum(Vec<(usize, f64)>),
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
        let place = |part: &Part| header.iter().position(|(_, cell)| *cell == part.column);
        let (mut sources, mut renamed) = (Vec::new(), Vec::new());
        for Renamed { name, sum_of } in columns {
            let places: Vec<(usize, f64)> =
                sum_of.iter().filter_map(|part| Some((place(part)?, part.factor))).collect();
            for missing in sum_of.iter().filter(|part| place(part).is_none()).map(|part| &part.column) {
                let names = allowed(missing, header.iter().map(|(_, cell)| cell.as_str()));
                let found = format!("column \"{missing}\" of [columns] is missing");
                notes.add(line, 1, &found, &names, "Name a column of this table in the setup file.");
            }
            renamed.push((places.first().map_or(1, |&(first, _)| header[first].0), name.clone()));
            sources.push(Source::Sum(places));
        }
        // A table of one setup has no reason to name it in each row.
        if let (Some([setup]), false) = (setups, columns.iter().any(|column| column.name == SETUP)) {
            sources.push(Source::Setup(setup.name.clone()));
            renamed.push((1, SETUP.into()));
        }
        (Self::To(sources), renamed)
    }

    /// Whether the points take anything from this place of a row.
    pub fn reads(&self, place: usize) -> bool {
        let from = |source: &Source| match source {
            Source::Setup(_) => false,
            Source::Sum(parts) => parts.iter().any(|(from, _)| *from == place),
        };
        match self {
            Self::None => true,
            Self::To(sources) => sources.iter().any(from),
        }
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
        let parts = match self {
            Self::Setup(name) => return (1, name.clone()),
            Self::Sum(parts) => parts,
        };
        // A column as it stands may hold a name, of a setup or of a target.
        if let [(place, 1.0)] = parts[..] {
            return cells[place].clone();
        }
        let mut sum = 0.0;
        for &(place, factor) in parts {
            match cells[place].1.parse::<f64>() {
                Ok(number) => sum += factor * number,
                // What is no number is reported where it stands.
                Err(_) => return cells[place].clone(),
            }
        }
        let begins = parts.first().map_or(1, |&(first, _)| cells[first].0);
        (begins, sum.to_string())
    }
}
