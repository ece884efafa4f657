//! Bars, columns and paragraphs of characters.

use crate::number::{plain, unit_on_screen};
use trunnion_results::Moved;

/// Longest bar, characters: a row of the widest table fits 80 columns.
pub(super) const BAR: f64 = 24.0;

/// A bar as long as the share of `largest`.
pub(super) fn bar(value: f64, largest: f64) -> String {
    let share = value / largest;
    if share.is_finite() { "#".repeat((share * BAR).round().clamp(0.0, BAR) as usize) } else { String::new() }
}

/// One indented line; the terminal wraps it.
pub(super) fn paragraph(text: &str) -> String {
    match clean(text).split_whitespace().collect::<Vec<_>>().join(" ") {
        line if line.is_empty() => line,
        line => format!("  {line}\n"),
    }
}

/// Columns two blanks apart; those in `right` are aligned right.
pub(super) fn columns(rows: &[Vec<String>], right: &[usize]) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| clean(cell)).collect()).collect();
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |j: usize| rows.iter().filter_map(|row| row.get(j)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut out = String::new();
    for row in &rows {
        let cells = row.iter().enumerate().map(|(j, cell)| match right.contains(&j) {
            true => format!("{cell:>width$}", width = widths[j]),
            false => format!("{cell:<width$}", width = widths[j]),
        });
        out += cells.collect::<Vec<_>>().join("  ").trim_end();
        out.push('\n');
    }
    out
}

/// One line without control characters: a name cannot move the cursor or colour the terminal.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Parameters that moved, most moved first.
pub(super) fn moved_table(moved: &[Moved]) -> String {
    let mut rows = vec![["parameter", "before", "after", "", "moved by"].map(String::from).to_vec()];
    rows.extend(moved.iter().map(|m| {
        vec![
            m.name.clone(),
            plain(m.before),
            plain(m.after),
            unit_on_screen(&m.unit),
            format!("{:.1} u", m.in_u()),
        ]
    }));
    columns(&rows, &[1, 2, 4])
}
