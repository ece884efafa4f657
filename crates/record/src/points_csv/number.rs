//! What to do with a cell that holds no number.

use crate::column::Column;

/// Marks between thousands, or a decimal mark that the other rows do not have.
const MARKS: [char; 6] = [',', '\'', '’', ' ', '\u{a0}', '\u{202f}'];
/// What programs write where nothing was read.
const NOTHING: [&str; 6] = ["", "-", "--", "nan", "n/a", "null"];

/// What may stand in the cell, and what to change in the file.
pub(super) fn expected(column: &Column, cell: &str) -> (&'static str, &'static str) {
    let is_number = |text: &str| text.parse().is_ok_and(|number: f64| number.is_finite());
    if let Column::Direction(_) = column {
        let advice =
            "Write 1 where the axis came from below, -1 where it came from above, 0 where that is not known.";
        return ("-1, 0, 1", advice);
    }
    let advice = if is_number(&cell.replace(MARKS, "")) {
        "Write numbers without marks between thousands, and with the decimal mark of the other rows."
    } else if is_number(cell.trim_end_matches(|c: char| c.is_alphabetic() || " °%".contains(c))) {
        "Leave the unit out of the cells: it stands in the name of the column."
    } else if NOTHING.contains(&cell.to_lowercase().as_str()) {
        "Leave out rows in which something was not read."
    } else {
        ""
    };
    ("a finite number", advice)
}
