//! What a named method found, for the terminal.

use super::table::{clean, paragraph, titled};
use crate::findings::{VALUE_HEADS, cells, heads, numeric, to_do, value_row, verdict};
use trunnion_results::Findings;

/// Values, notes and tables; charts are on the page.
pub fn findings_text(findings: &Findings) -> String {
    let mut out =
        format!("Machine {}, runs: {}\n", clean(&findings.machine), clean(&findings.runs.join(", ")));
    out += &format!("Method: {} [{}]\n", findings.method, clean(&findings.source));
    out += &format!("Signs: {}\n\n", findings.convention);
    for sentence in verdict(findings) {
        out += &paragraph(&sentence);
    }
    let to_do = to_do(findings);
    if !to_do.is_empty() {
        out += "\nWhat to do:\n";
        for (number, text) in (1..).zip(&to_do) {
            out += &paragraph(&format!("{number}. {text}"));
        }
    }
    if !findings.values.is_empty() {
        let mut rows = vec![VALUE_HEADS.map(String::from).to_vec()];
        rows.extend(findings.values.iter().map(value_row));
        out += &format!("\n{}", titled(&rows, &[1, 2]));
    }
    for note in &findings.notes {
        out += "\n";
        out += &paragraph(note);
    }
    for table in &findings.tables {
        out += &format!("\n{}\n", clean(&table.caption));
        let mut rows = vec![heads(table)];
        rows.extend(table.rows.iter().map(|row| cells(table, row)));
        out += &titled(&rows, &numeric(table));
    }
    out
}
