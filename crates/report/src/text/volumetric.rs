//! Volumetric accuracy and location errors in a notation, for the terminal.

use super::table::{clean, columns, paragraph};
use crate::volumetric::{HEADS, location_rows, notes, rows};
use trunnion_results::{LocationErrors, Volumetric};

/// The values and what they lack; `volume` in words.
pub fn volumetric_text(answer: &Volumetric, volume: &str) -> String {
    let mut out = format!("Machine {}, runs: {}\n", clean(&answer.machine), clean(&answer.runs.join(", ")));
    out += &format!("Volume: {} ({} places)\n\n", clean(volume), answer.places);
    let mut table = vec![HEADS.map(String::from).to_vec()];
    table.extend(rows(answer));
    out += &columns(&table, &[1, 2]);
    for note in notes(answer) {
        out += "\n";
        out += &paragraph(&note);
    }
    out
}

/// Location errors in a notation.
pub fn location_text(errors: &LocationErrors) -> String {
    let source = match errors.notation.as_str() {
        "absolute" => {
            "lines of the axes in the machine coordinate system (ISO 230-1; Ibaraki and Knapp 2012, tables 2 and 3)"
        }
        _ => "lines of the axes against the axis that carries them (Ibaraki and Knapp 2012, tables 4 and 5)",
    };
    format!(
        "\nLocation errors, {}: {source}\n{}",
        errors.notation,
        columns(&location_rows(&errors.values), &[1, 2])
    )
}
