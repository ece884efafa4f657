//! The compare report as one self-contained HTML page, told from the verdict down to the tables.

mod candidates;
mod findings;
mod ladder;
mod maps;
mod parameters;
mod places;
mod polars;
mod positions;
mod summary;
mod sure;
mod sweeps;
mod timing;
mod trial;
mod volumetric;

use crate::markup::{element, escape};
use crate::number::um;
use crate::{CompareInput, LadderRow, Trial};
use trunnion_methods::volumetric::VolumetricMap;
use trunnion_results::Findings;

const STYLE: &str = include_str!("html/style.css");

/// One page with everything: no outside asset, readable on a phone, on paper, in the dark. UTF-8, well-formed as XML.
pub fn compare_html(input: &CompareInput) -> String {
    let sections = [
        summary::section(input),
        places::section(input),
        candidates::section(input),
        sure::section(input),
        ladder::section(input),
        maps::section(input),
        sweeps::section(input),
        polars::section(input),
        positions::section(input),
        parameters::section(input),
        losses(input),
        timing::section(&input.timing),
    ];
    page(&format!("Trunnion report: {}", input.identification.machine), &sections.concat())
}

/// One page on what one effect would do: the residual before and after, on one colour scale.
pub fn trial_html(input: &CompareInput, trial: &Trial) -> String {
    let title = format!("Trunnion: {} on trial on {}", trial.effect, input.identification.machine);
    let sections = [trial::headline(input, trial), trial::places(trial), trial::all_maps(input, trial)];
    page(&title, &(sections.concat() + &trial::tables(trial)))
}

/// One page on what a named method found, with its charts.
pub fn findings_html(findings: &Findings, label: &str) -> String {
    let title = format!("Trunnion: {} on {}", findings.method, findings.machine);
    page(&title, &findings::sections(findings, label))
}

/// One page on the volumetric accuracy that a model says, with the distorted volume in three views; `volume` in words.
pub fn volumetric_html(map: &VolumetricMap, volume: &str, label: &str) -> String {
    page(
        &format!("Trunnion: volumetric accuracy of {}", map.machine),
        &volumetric::sections(map, volume, label),
    )
}

/// The ladder of a model alone.
pub fn ladder_html(machine: &str, rows: &[LadderRow]) -> String {
    let input = CompareInput { ladder: rows.to_vec(), ..CompareInput::default() };
    let section = match rows.is_empty() {
        true => element("p", "No effect was added to this model yet."),
        false => ladder::section(&input),
    };
    let head = element("h1", &ladder_verdict(machine, rows));
    page(&format!("Trunnion ladder: {machine}"), &format!("{head}\n{section}"))
}

/// What the ladder comes to, in one line.
fn ladder_verdict(machine: &str, rows: &[LadderRow]) -> String {
    let Some((first, last)) = rows.first().zip(rows.last()) else { return format!("Machine {machine}") };
    let effects = if rows.len() == 1 { "one effect".into() } else { format!("{} effects", rows.len()) };
    let floor = last.noise_um.map_or(String::new(), |noise| format!(" (repeatability {})", um(noise)));
    format!(
        "Machine {machine}: {effects} took the error from {} to {}{floor}",
        um(first.fit_before_um),
        um(last.fit_after_um)
    )
}

fn page(title: &str, sections: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
         <meta name=\"color-scheme\" content=\"light dark\"/><title>{}</title>\n<style>\n{STYLE}</style></head>\n\
         <body><main>\n{sections}</main></body></html>\n",
        escape(title),
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
