//! Bars, columns and paragraphs of characters.

use crate::number::{MISSING, justified, unit_on_screen};
use trunnion_results::Moved;

/// Longest bar, characters.
const BAR: f64 = 24.0;
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

/// Length of the longest bar after these columns: the longest ends where the screen does.
pub(super) fn longest_bar(rows: &[Vec<String>]) -> f64 {
    let used: usize = widths(rows).iter().map(|width| width + GAP).sum();
    SCREEN.saturating_sub(used).clamp(SHORTEST, BAR as usize) as f64
}

/// Rows with a bar for each value at their end.
pub(super) fn with_bars(mut rows: Vec<Vec<String>>, values: &[f64]) -> Vec<Vec<String>> {
    let longest = longest_bar(&rows);
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

/// Each sentence between empty lines: as an item of a list, or below a table, the terminal would fold it away.
pub(super) fn set_apart(sentences: &[String]) -> String {
    sentences.iter().map(|sentence| format!("\n{}", paragraph(sentence))).collect()
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

/// A table whose first row is its head, for a screen of [`SCREEN`] columns. Columns without any content are left out. A
/// remark in the last column that repeats and does not fit stands once below the table, with a mark. Columns that do not fit
/// follow in a table of their own, after those that name the rows. Nothing where there is no row.
pub(super) fn titled(rows: &[Vec<String>], right: &[usize]) -> String {
    let Some((head, body)) = rows.split_first().filter(|(_, body)| !body.is_empty()) else {
        return String::new();
    };
    let has_content =
        |j: &usize| body.iter().filter_map(|row| row.get(*j)).any(|cell| !cell.is_empty() && cell != MISSING);
    let kept: Vec<usize> = (0..head.len()).filter(has_content).collect();
    let right = among(&kept, right);
    let rows = picked(rows, &kept);
    let (last, key) = (kept.len().saturating_sub(1), naming(&rows));
    let part = |(nth, block): (usize, Vec<usize>)| {
        let mut part = picked(&rows, &block);
        // What continues below leaves out the rows of which it has nothing.
        part.retain(|row| nth == 0 || row[key..].iter().any(|cell| !cell.is_empty() && cell != MISSING));
        let wraps = block.last() == Some(&last) && !right.contains(&last);
        let remarks = if wraps { mark_remarks(&mut part) } else { String::new() };
        columns(&part, &among(&block, &right)) + &remarks
    };
    blocks(&rows, &right, key).into_iter().enumerate().map(part).collect::<Vec<_>>().join("\n")
}

/// These columns of each row.
fn picked(rows: &[Vec<String>], kept: &[usize]) -> Vec<Vec<String>> {
    let pick = |row: &Vec<String>| kept.iter().map(|&j| row.get(j).cloned().unwrap_or_default()).collect();
    rows.iter().map(pick).collect()
}

/// Where the columns `of` are among those that are kept.
fn among(kept: &[usize], of: &[usize]) -> Vec<usize> {
    (0..kept.len()).filter(|&at| of.contains(&kept[at])).collect()
}

/// Replaces each remark that repeats and does not fit by a mark; what the marks stand for, a line each.
fn mark_remarks(rows: &mut [Vec<String>]) -> String {
    let widths = widths(rows);
    let Some((_, before)) = widths.split_last() else { return String::new() };
    let room = SCREEN.saturating_sub(before.iter().map(|width| width + GAP).sum());
    let last = before.len();
    let mut long: Vec<String> = Vec::new();
    for row in &*rows {
        let remark = &row[last];
        let repeats = rows.iter().filter(|row| row[last] == *remark).count() > 1;
        if repeats && remark.chars().count() > room && !long.contains(remark) {
            long.push(remark.clone());
        }
    }
    for row in rows {
        if let Some(at) = long.iter().position(|remark| *remark == row[last]) {
            row[last] = mark(at);
        }
    }
    // Apart from the table: what continues its last row is folded away with it.
    let remark =
        |(at, remark): (usize, &String)| format!("\n{}", paragraph(&format!("{} {remark}", mark(at))));
    long.iter().enumerate().map(remark).collect()
}

/// `[1]` for the first.
fn mark(at: usize) -> String {
    format!("[{}]", at + 1)
}

/// The columns of each part of a table that is wider than the screen. Text in the last column of all may be longer: the
/// terminal wraps it, as long as its head fits.
fn blocks(rows: &[Vec<String>], right: &[usize], key: usize) -> Vec<Vec<usize>> {
    let widths = widths(rows);
    let key: Vec<usize> = (0..key).collect();
    let mut blocks = Vec::new();
    let mut block = key.clone();
    for j in key.len()..widths.len() {
        let used: usize = block.iter().map(|&k| widths[k] + GAP).sum();
        let wraps = j + 1 == widths.len() && !right.contains(&j);
        let needed = if wraps { rows[0][j].chars().count() } else { widths[j] };
        if used + needed > SCREEN && block.len() > key.len() {
            blocks.push(std::mem::replace(&mut block, key.clone()));
        }
        block.push(j);
    }
    blocks.push(block);
    blocks
}

/// How many columns name each row; two at most, else a part has room for little more.
fn naming(rows: &[Vec<String>]) -> usize {
    let names: std::collections::BTreeSet<&String> = rows.iter().filter_map(|row| row.first()).collect();
    let columns = rows.first().map_or(0, Vec::len);
    if names.len() == rows.len() { 1.min(columns) } else { 2.min(columns) }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(rows: &[&[&str]]) -> Vec<Vec<String>> {
        rows.iter().map(|row| row.iter().map(ToString::to_string).collect()).collect()
    }

    #[test]
    fn a_column_without_content_is_left_out() {
        let table = rows(&[&["value", "", "u", "remark"], &["a", "1", "—", ""], &["b", "20", "—", ""]]);
        assert_eq!(titled(&table, &[1, 2]), "value\na       1\nb      20\n");
        assert_eq!(titled(&table[..1], &[1, 2]), "", "a head alone is no table");
    }

    #[test]
    fn a_long_remark_that_repeats_stands_once_below_the_table() {
        let long = "because ".repeat(9) + "of that";
        let table = rows(&[&["value", "remark"], &["a", &long], &["b", "short"], &["c", &long]]);
        assert_eq!(
            titled(&table, &[]),
            format!("value  remark\na      [1]\nb      short\nc      [1]\n\n  [1] {long}\n")
        );
        // Once, it stays in its row: the terminal wraps it.
        assert!(titled(&table[..3], &[]).ends_with(&format!("a      {long}\nb      short\n")));
    }

    #[test]
    fn what_is_wider_than_the_screen_continues_below_with_the_names_of_its_rows() {
        let names: Vec<String> = (0..12).map(|j| format!("head {j:02} (µm)")).collect();
        let head: Vec<&str> = names.iter().map(String::as_str).collect();
        let values = ["1", "x", "3", "4", "5", "6", "7", "8", "9", "10", "—", "—"];
        let others = ["1", "y", "30", "40", "50", "60", "70", "80", "90", "100", "110", "120"];
        let text = titled(&rows(&[&head, &values, &others]), &[0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]);
        assert!(text.lines().all(|line| line.chars().count() <= SCREEN), "{text}");
        let parts: Vec<&str> = text.split("\n\n").collect();
        let (last, others_of_all) = parts.split_last().unwrap();
        assert!(others_of_all.len() > 1, "{text}");
        assert!(others_of_all.iter().all(|part| part.contains('x') && part.contains('y')), "{text}");
        assert!(last.contains('y') && !last.contains('x'), "a row without content is left out: {text}");
        for cell in names.iter().map(String::as_str).chain(values).chain(others) {
            assert!(text.contains(cell), "{cell} in {text}");
        }
    }
}
