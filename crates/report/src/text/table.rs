//! Bars, columns and paragraphs of characters.

use crate::number::{justified, unit_on_screen};
use trunnion_results::Moved;

/// Longest bar, characters.
pub(super) const BAR: f64 = 24.0;
/// Shortest scale of bars that shows a difference.
const SHORTEST: usize = 8;
/// Columns of a terminal that nobody made wider; the cell of a bar is the last of its row.
const SCREEN: usize = 80;

/// A bar as long as the share of `largest`.
pub(super) fn bar(value: f64, largest: f64) -> String {
    scaled(value, largest, BAR)
}

fn scaled(value: f64, largest: f64, longest: f64) -> String {
    let share = value / largest;
    if share.is_finite() {
        "#".repeat((share * longest).round().clamp(0.0, longest) as usize)
    } else {
        String::new()
    }
}

/// Rows with a bar for each value at their end; the longest ends where the screen does.
pub(super) fn with_bars(mut rows: Vec<Vec<String>>, values: &[f64]) -> Vec<Vec<String>> {
    let used: usize = widths(&rows).iter().map(|width| width + GAP).sum();
    let longest = SCREEN.saturating_sub(used).clamp(SHORTEST, BAR as usize) as f64;
    let largest = values.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
    rows.iter_mut().zip(values).for_each(|(row, value)| row.push(scaled(*value, largest, longest)));
    rows
}

/// One indented line; the terminal wraps it.
pub(super) fn paragraph(text: &str) -> String {
    match clean(text).split_whitespace().collect::<Vec<_>>().join(" ") {
        line if line.is_empty() => line,
        line => format!("  {line}\n"),
    }
}

/// Blanks between two columns.
const GAP: usize = 2;

/// Columns two blanks apart; those in `right` are aligned right.
pub(super) fn columns(rows: &[Vec<String>], right: &[usize]) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| clean(cell)).collect()).collect();
    let widths = widths(&rows);
    let mut out = String::new();
    for row in &rows {
        let cells = row.iter().enumerate().map(|(j, cell)| match right.contains(&j) {
            true => format!("{cell:>width$}", width = widths[j]),
            false => format!("{cell:<width$}", width = widths[j]),
        });
        out += cells.collect::<Vec<_>>().join(&" ".repeat(GAP)).trim_end();
        out.push('\n');
    }
    out
}

/// Characters of the widest cell of each column.
fn widths(rows: &[Vec<String>]) -> Vec<usize> {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width =
        |j: usize| rows.iter().filter_map(|row| row.get(j)).map(|c| c.chars().count()).max().unwrap_or(0);
    (0..count).map(width).collect()
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
            justified(m.before, m.u),
            justified(m.after, m.u),
            unit_on_screen(&m.unit),
            format!("{:.1} u", m.in_u()),
        ]
    }));
    columns(&rows, &[1, 2, 4])
}
