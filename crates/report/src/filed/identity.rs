//! Whose report it is: machine, people, recordings.

use crate::markup::{element, escape};
use crate::number::{MISSING, fixed};
use trunnion_results::{Identity, Report, RunIdentity, TemperatureRange, sentences};

const NOT_RECORDED: &str = "not recorded";

pub fn section(report: &Report) -> String {
    let identity = &report.identity;
    let about = [
        ("Machine file", identity.machine.clone()),
        ("Serial number", identity.serial.clone().unwrap_or_else(|| NOT_RECORDED.into())),
        ("Operator", identity.operator.clone().unwrap_or_else(|| NOT_RECORDED.into())),
        ("Model", report.comparison.identification.effects.join(" + ")),
        ("Report written", format!("{}, {}", identity.written, identity.program)),
    ];
    let mut body = rows("Machine and report", about.map(|(name, value)| (name, vec![value])).as_slice());
    for run in &identity.runs {
        body += &of_run(run);
    }
    let complete = sentences::complete(&report.comparison.identification.complete);
    let complete: String = complete.iter().map(|text| element("li", text)).collect();
    if !complete.is_empty() {
        body += &format!("<h3>Completeness</h3>\n<ul>{complete}</ul>\n");
    }
    format!("<section class=\"page\"><h2>Machine and measurement</h2>\n{body}</section>\n")
}

/// The days on which was measured, for the first page.
pub fn measured(identity: &Identity) -> String {
    let mut days: Vec<&str> = identity.runs.iter().filter_map(|run| run.day.as_deref()).collect();
    days.dedup();
    if days.is_empty() { NOT_RECORDED.into() } else { days.join(", ") }
}

fn of_run(run: &RunIdentity) -> String {
    let kind = if run.on_the_fly { "on the fly" } else { "at rest" };
    let or_not = |lines: Vec<String>| if lines.is_empty() { vec![NOT_RECORDED.into()] } else { lines };
    let cycle = Some(run.cycle.clone()).filter(|name| !name.is_empty());
    let about = [
        ("File", vec![run.file.clone()]),
        ("SHA-256 of the file", vec![run.sha256.clone()]),
        ("Began", or_not(run.began.iter().cloned().collect())),
        ("Cycle", or_not(cycle.into_iter().collect())),
        ("Taken", vec![kind.into()]),
        ("Setups", run.setups.clone()),
        ("Probes", or_not(run.probes.clone())),
        ("Probe calibration (directions in nest axes)", or_not(run.probe_calibration.clone())),
        ("Temperatures", or_not(run.temperatures.iter().map(temperature).collect())),
        ("Recorded with", vec![format!("Trunnion {}", run.recorded_with)]),
    ];
    rows(&format!("Run {}", run.run), &about)
}

fn temperature(range: &TemperatureRange) -> String {
    let TemperatureRange { channel, lowest_degc, mean_degc, highest_degc } = range;
    let [lowest, mean, highest] = [lowest_degc, mean_degc, highest_degc].map(|degc| fixed(*degc, 1));
    match lowest == highest {
        true => format!("{channel}: {mean} °C"),
        false => format!("{channel}: {lowest} to {highest} °C, {mean} °C on average"),
    }
}

fn rows(caption: &str, rows: &[(&str, Vec<String>)]) -> String {
    let row = |(name, lines): &(&str, Vec<String>)| {
        let lines: String = match lines.as_slice() {
            [] => MISSING.into(),
            lines => lines.iter().map(|line| format!("<div>{}</div>", escape(line))).collect(),
        };
        format!("<tr><th scope=\"row\">{}</th><td>{lines}</td></tr>\n", escape(name))
    };
    format!(
        "<table class=\"identity\"><caption>{}</caption><tbody>\n{}</tbody></table>\n",
        escape(caption),
        rows.iter().map(row).collect::<String>()
    )
}
