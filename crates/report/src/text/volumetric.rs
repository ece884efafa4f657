//! Volumetric accuracy and location errors in a notation, for the terminal.

use super::{clean, columns, paragraph};
use crate::volumetric::{HEADS, location_rows, notes, rows};
use trunnion_methods::notation::{LocationError, Notation};
use trunnion_methods::volumetric::VolumetricMap;

/// The values and what they lack; `volume` in words.
pub fn volumetric_text(map: &VolumetricMap, volume: &str) -> String {
    let mut out = format!("Machine {}, runs: {}\n", clean(&map.machine), clean(&map.runs.join(", ")));
    out += &format!("Volume: {} ({} places)\n\n", clean(volume), map.points.len());
    let mut table = vec![HEADS.map(String::from).to_vec()];
    table.extend(rows(map));
    out += &columns(&table, &[1, 2]);
    for note in notes(map) {
        out += "\n";
        out += &paragraph(&note);
    }
    out
}

/// Location errors in a notation.
pub fn location_text(errors: &[LocationError], notation: Notation) -> String {
    let source = match notation {
        Notation::Absolute => {
            "lines of the axes in the machine coordinate system (ISO 230-1; S2 tables 2 and 3)"
        }
        Notation::Relative => "lines of the axes against the axis that carries them (S2 tables 4 and 5)",
    };
    format!("\nLocation errors, {}: {source}\n{}", notation.name(), columns(&location_rows(errors), &[1, 2]))
}
