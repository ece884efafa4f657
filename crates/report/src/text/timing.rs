//! Time quality in the terminal.

use super::table::{clean, columns, paragraph};
use crate::time_quality::{HEAD, NUMERIC, rows, sentences};
use std::iter::once;
use trunnion_results::TimeQuality;

/// What is known of every stream's clock; empty without runs.
pub fn timing_text(timing: &[TimeQuality]) -> String {
    let mut out = String::new();
    for quality in timing {
        out += &format!("\nTime quality of {}\n", clean(&quality.run));
        let table: Vec<_> = once(HEAD.map(String::from).to_vec()).chain(rows(quality)).collect();
        out += &columns(&table, &NUMERIC);
        for sentence in sentences(quality) {
            out += &paragraph(&clean(&sentence));
        }
    }
    out
}
