//! The compare report as one self-contained HTML page.

mod diagnosis;
mod ladder;
mod maps;
mod parameters;
mod polars;
mod positions;
mod summary;
mod sweeps;

use crate::CompareInput;
use crate::markup::{element, escape};

const STYLE: &str = include_str!("html/style.css");

/// One page with everything: no outside asset, readable on a phone, on paper, in the dark. UTF-8, well-formed as XML.
pub fn compare_html(input: &CompareInput) -> String {
    let sections = [
        summary::section(input),
        diagnosis::section(input),
        ladder::section(input),
        maps::section(input),
        sweeps::section(input),
        polars::section(input),
        positions::section(input),
        parameters::section(input),
        losses(input),
    ];
    let title = format!("Trunnion report: {}", input.identification.machine);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
         <meta name=\"color-scheme\" content=\"light dark\"/><title>{}</title>\n<style>\n{STYLE}</style></head>\n\
         <body><main>\n{}</main></body></html>\n",
        escape(&title),
        sections.concat(),
    )
}

fn losses(input: &CompareInput) -> String {
    let outliers = input.identification.outliers;
    let mut notes = input.losses.clone();
    if outliers > 0 {
        notes.push(format!(
            "{outliers} of {} points lay far from the rest and were set aside; they are in no figure here.",
            input.identification.points
        ));
    }
    let list = if notes.is_empty() {
        "<p>Nothing is missing from the recording, and no point was set aside.</p>".to_owned()
    } else {
        format!(
            "<ul class=\"warn\">{}</ul>",
            notes.iter().map(|note| element("li", note)).collect::<String>()
        )
    };
    format!("<section><h2>What is missing from the data</h2>\n{list}</section>\n")
}
