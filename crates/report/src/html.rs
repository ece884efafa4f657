//! The compare report as one self-contained HTML page, from the verdict down to the tables.

mod added;
mod candidates;
mod findings;
mod ladder;
mod maps;
mod parameters;
mod places;
mod polars;
mod positions;
mod spectrum;
mod summary;
mod sure;
mod sweeps;
mod timing;
mod trial;
mod volumetric;

use crate::added::causes;
use crate::markup::{element, escape};
use crate::number::um;
use trunnion_results::sentences::{complete, samples};
use trunnion_results::{Comparison, Complete, ErrorMap, Findings, Ladder, Trial, Volumetric};

pub use positions::magnification;

/// The style of every page.
pub const PAGE_CSS: &str = include_str!("html/style.css");

/// One page with everything: no outside asset, readable on a phone, on paper, in the dark. UTF-8, well-formed as XML.
pub fn compare_html(input: &Comparison, label: &str) -> String {
    let mut body = summary::section(input, label);
    for (name, section) in compare_sections(input) {
        body += &section;
        if name == "candidates" {
            body += &sure::section(input);
        }
    }
    page(&format!("Trunnion report: {}", input.identification.machine), &body)
}

/// The charts and tables of the compare report, each with its name, in order; empty where there is nothing to show.
pub(crate) fn compare_sections(input: &Comparison) -> Vec<(&'static str, String)> {
    vec![
        ("added", added::section(input)),
        ("ladder", ladder::section(&input.ladder)),
        ("places", places::section(input)),
        ("spectrum", spectrum::section(&input.spectra)),
        ("candidates", candidates::section(input)),
        ("maps", maps::section(&input.residuals)),
        ("sweeps", sweeps::section(&input.residuals)),
        ("polars", polars::section(&input.residuals)),
        ("positions", positions::section(&input.residuals)),
        ("parameters", parameters::section(input)),
        ("missing", losses(input)),
        ("timing", timing::section(&input.time_quality)),
    ]
}

/// One page on what one effect would do: the residual before and after, on one colour scale.
pub fn trial_html(trial: &Trial, label: &str) -> String {
    let title = format!("Trunnion: {} on trial on {}", trial.effect, trial.identification.machine);
    let spectra = match spectrum::before_and_after(&trial.spectra) {
        charts if charts.is_empty() => charts,
        charts => format!("<section>{charts}</section>\n"),
    };
    let sections = [trial::headline(trial, label), trial::places(trial), trial::all_maps(trial), spectra];
    page(&title, &(sections.concat() + &trial::tables(trial)))
}

/// One page on what a named method found, with its charts.
pub fn findings_html(findings: &Findings, label: &str) -> String {
    let title = format!("Trunnion: {} on {}", findings.method, findings.machine);
    page(&title, &findings::sections(findings, label))
}

/// One page on the volumetric accuracy that a model says, with the distorted volume in three views; `volume` in words.
pub fn volumetric_html(answer: &Volumetric, map: &ErrorMap, volume: &str, label: &str) -> String {
    page(
        &format!("Trunnion: volumetric accuracy of {}", answer.machine),
        &volumetric::sections(answer, map, volume, label),
    )
}

/// The ladder of a model alone.
pub fn ladder_html(machine: &str, rungs: &Ladder) -> String {
    let section = match rungs.added().next() {
        None => element("p", "No effect was added to this model yet."),
        Some(_) => {
            causes(rungs).iter().map(|text| element("p", text)).collect::<String>() + &ladder::section(rungs)
        }
    };
    let head = element("h1", &ladder_verdict(machine, rungs));
    page(&format!("Trunnion ladder: {machine}"), &format!("{head}\n{section}"))
}

/// What the ladder comes to, in one line.
fn ladder_verdict(machine: &str, ladder: &Ladder) -> String {
    let ends = ladder.added().next().zip(ladder.added().next_back());
    let Some(((_, first), (_, last))) = ends else { return format!("Machine {machine}") };
    let effects = match ladder.added().count() {
        1 => "one effect".into(),
        count => format!("{count} effects"),
    };
    let floor = last.noise_um.map_or(String::new(), |noise| format!(" (repeatability {})", um(noise)));
    format!(
        "Machine {machine}: {effects} took the error from {} to {}{floor}",
        um(first.error_before_um),
        um(last.error_after_um)
    )
}

fn page(title: &str, sections: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
         <meta name=\"color-scheme\" content=\"light dark\"/><title>{}</title>\n<style>\n{PAGE_CSS}</style></head>\n\
         <body><main>\n{sections}</main></body></html>\n",
        escape(title),
    )
}

fn losses(input: &Comparison) -> String {
    let found = &input.identification.complete;
    let whole = found.missing.is_empty() && found.excluded.is_empty();
    let listed = |notes: &[String]| {
        let items: String = notes.iter().map(|note| element("li", note)).collect();
        format!("<ul class=\"warn\">{items}</ul>")
    };
    let points = if whole {
        let all = found
            .planned
            .map_or_else(String::new, |planned| format!("All {planned} planned points were read. "));
        let samples: String = found.samples.iter().map(|run| element("p", &samples(run))).collect();
        let gaps = match input.losses.is_empty() {
            true => "Nothing is missing from the recording, and no point was excluded.",
            false => "No point was excluded.",
        };
        format!("<p>{all}{gaps}</p>{samples}")
    } else {
        // That everything was read is no warning.
        let all = found.planned.filter(|planned| *planned == found.read);
        let warned = Complete {
            planned: found.planned.filter(|planned| *planned != found.read),
            samples: Vec::new(),
            losses: Vec::new(),
            ..found.clone()
        };
        let read =
            all.map_or_else(String::new, |all| element("p", &format!("All {all} planned points were read.")));
        let samples: String = found.samples.iter().map(|run| element("p", &samples(run))).collect();
        format!("{read}{}{samples}", listed(&complete(&warned)))
    };
    let gaps = match input.losses.is_empty() {
        true => String::new(),
        false => format!("<p>The recording is not whole:</p>{}", listed(&input.losses)),
    };
    let left_out = match input.left_out.is_empty() {
        true => String::new(),
        false => format!("<p>This report lacks:</p>{}", listed(&input.left_out)),
    };
    format!("<section><h2>What is missing from the data</h2>\n{points}{gaps}{left_out}</section>\n")
}
