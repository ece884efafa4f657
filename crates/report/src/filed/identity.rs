//! Whose report it is: machine, people, recordings.

use crate::markup::{element, escape, table};
use crate::number::{MISSING, fixed};
use trunnion_results::{Identity, Report, RunIdentity, SensorCalibration, TemperatureRange, sentences};

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

/// Which sensors are calibrated, by which certificates, and when: one line each, for the first page.
pub fn calibrated(identity: &Identity) -> Vec<String> {
    let line = |of: &SensorCalibration| {
        let known: Vec<&str> =
            [&of.serial, &of.certificate, &of.date].into_iter().flatten().map(String::as_str).collect();
        if known.is_empty() { of.sensor.clone() } else { format!("{}: {}", of.sensor, known.join(", ")) }
    };
    let mut lines: Vec<String> = Vec::new();
    for line in identity.runs.iter().flat_map(|run| run.calibrations.iter().map(line)) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    if lines.is_empty() { vec![NOT_RECORDED.into()] } else { lines }
}

/// What the certificates of the sensors of a run say.
fn calibrations(run: &RunIdentity) -> String {
    let head = ["sensor", "serial number", "certificate", "laboratory", "calibrated", "valid until"];
    let row = |of: &SensorCalibration| {
        let known = [&of.serial, &of.certificate, &of.laboratory, &of.date, &of.valid_until];
        let cells = known.map(|text| text.clone().unwrap_or_else(|| MISSING.into()));
        [of.sensor.clone()].into_iter().chain(cells).collect()
    };
    let rows: Vec<Vec<String>> = run.calibrations.iter().map(row).collect();
    if rows.is_empty() { String::new() } else { table("Calibration certificates", &head, &[], &rows) }
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
    let none = run.calibrations.is_empty().then(|| ("Calibration certificates", vec![NOT_RECORDED.into()]));
    let about: Vec<_> = about.into_iter().chain(none).collect();
    rows(&format!("Run {}", run.run), &about) + &calibrations(run)
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
