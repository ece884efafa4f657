//! Numbers of a file, as read.

use std::collections::BTreeMap;

/// Column name and its values: one without argument, or many with.
#[derive(Default)]
pub(super) struct Numbers {
    /// Position errors by (axis, direction).
    pub constants: BTreeMap<(usize, usize), f64>,
    /// Component errors by (axis, direction): argument and value, as in the file.
    pub curves: BTreeMap<(usize, usize), Vec<(f64, f64)>>,
}

/// A line of a file with its number.
pub(super) type Line<'a> = (usize, &'a str);

/// Line, what was found, what would be allowed.
pub(super) type Found = (usize, String, &'static str);

/// A number that is finite.
pub(super) fn number(line: usize, text: &str) -> Result<f64, Found> {
    let parsed = text.parse().ok().filter(|value: &f64| value.is_finite());
    parsed.ok_or_else(|| (line, format!("\"{text}\""), "a number with a decimal point"))
}
