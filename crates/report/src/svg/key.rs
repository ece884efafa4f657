//! The key of a chart: samples of its marks with their names, in as many rows as they need.

use super::element::{line, text};
use super::mark::{Mark, symbol};

/// Baseline of the first row.
pub(super) const FIRST_ROW: f64 = 13.0;
const ROW: f64 = 15.0;
/// Sample and the gap after a name.
const SAMPLE: f64 = 22.0;
const GAP: f64 = 12.0;
/// Mean width of a character of a chart.
const CHARACTER: f64 = 6.5;

/// How far a text of a chart goes, about.
pub(super) fn length(text: &str) -> f64 {
    CHARACTER * text.chars().count() as f64
}

/// Samples and names from `begin` on, further rows from `left` on, none beyond `right`; and the baseline of the last row.
pub(super) fn keys(entries: &[(Mark, &str)], begin: f64, (left, right): (f64, f64)) -> (String, f64) {
    let (mut x, mut baseline, mut body) = (begin, FIRST_ROW, String::new());
    for (mark, name) in entries {
        let width = SAMPLE + length(name);
        if x > left && x + width > right {
            (x, baseline) = (left, baseline + ROW);
        }
        body += &sample(*mark, x, baseline);
        body += &text(x + SAMPLE, baseline, "t", name);
        x += width + GAP;
    }
    (body, baseline)
}

fn sample(mark: Mark, x: f64, baseline: f64) -> String {
    let (x, y) = (x + 8.0, baseline - 3.5);
    match mark.line_class() {
        Some(class) => line((x - 4.0, y), (x + 10.0, y), class),
        None => symbol(mark, x + 5.0, y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_too_long_goes_on_in_the_next_row() {
        let (_, last) = keys(&[(Mark::Line, "EX0C"), (Mark::Dashed, "EY0C")], 100.0, (40.0, 352.0));
        assert_eq!(last, FIRST_ROW);
        let long = "a name of a curve that is long";
        let (body, last) = keys(&[(Mark::Line, long), (Mark::Dashed, long)], 100.0, (40.0, 352.0));
        assert_eq!(last, FIRST_ROW + ROW);
        assert!(body.contains("x=\"62.0\" y=\"28.0\""), "{body}");
    }
}
