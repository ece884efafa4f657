//! Every measurement scheme of the sources, from the command line on files that ship: simulated with one truth, identified, and
//! every number compared with the truth. The table of docs/measured/schemes.md is written from these rows.

#[path = "../src/carried.rs"]
mod carried;
#[path = "../src/schemes/judged.rs"]
mod judged;
#[path = "../src/schemes/named.rs"]
mod named;
#[path = "../src/schemes/rows.rs"]
mod rows;
#[path = "../src/schemes/volumetric.rs"]
mod volumetric;

use crate::section::{Section, is_writing, workspace_root};
use judged::{Found, found, injected};
use rows::{Row, rows};
use serde_json::Value;
use std::path::Path;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::Truth;

/// Deviations allowed, in standard uncertainties: of some 300 numbers none should be farther off.
const ALLOWED_U: f64 = 4.5;
/// What the linear uncertainty leaves out: errors of second order, in the last printed digit.
const SECOND_ORDER: f64 = 0.01;

fn trunnion(folder: &Path, args: &[&str]) -> String {
    let output = crate::program::command().current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn config(kind: &str, name: &str) -> String {
    workspace_root().join(format!("config/{kind}/{name}.toml")).display().to_string()
}

/// What was found against the injected values.
struct Outcome {
    /// How many readings, and what they leave.
    left: String,
    numbers: usize,
    worst_u: f64,
    /// The wanted numbers.
    wanted: Vec<Found>,
}

fn run(row: &Row, folder: &Path, wrong: &mut Vec<String>) -> Outcome {
    // Two rows may judge the same cycle.
    let recording = format!("{}-{}.mcap", row.cycle, row.method.unwrap_or("fit"));
    let (truth_file, cycle) = (config("truths", row.truth), config("cycles", row.cycle));
    trunnion(folder, &["simulate", &truth_file, "--cycle", &cycle, "-o", &recording]);
    let model = row.model.map(|model| config("models", model));
    let mut args = vec!["identify", recording.as_str(), "--json"];
    if let Some(model) = &model {
        args.extend(["--model", model]);
    }
    if let Some(method) = row.method {
        args.extend(["--method", method]);
    }
    let answer: Value = serde_json::from_str(&trunnion(folder, &args)).unwrap();
    let truth_text = std::fs::read_to_string(&truth_file).unwrap();
    let injected = injected(&truth_text, row.also);
    let numbers = match row.method {
        None => found(&answer, &injected),
        Some(_) => {
            let cycle = Cycle::parse(row.cycle, &std::fs::read_to_string(&cycle).unwrap()).unwrap();
            let truth = Truth::parse(row.truth, &truth_text).unwrap();
            named::found(row, &answer, &cycle, &truth, &injected)
        }
    };
    let mut worst_u = 0f64;
    for Found { name, value, u, expected, .. } in &numbers {
        let off = (value - expected).abs();
        worst_u = worst_u.max((off - SECOND_ORDER).max(0.0) / u);
        if off > ALLOWED_U * u + SECOND_ORDER {
            wrong.push(format!("{}: {name} = {value} ± {u}, injected {expected}", row.scheme));
        }
    }
    let is_wanted = |found: &&Found| row.identifies.contains(&found.name.as_str());
    let wanted: Vec<Found> = numbers.iter().filter(is_wanted).cloned().collect();
    for name in row.identifies {
        if !wanted.iter().any(|found| found.name == *name) {
            wrong.push(format!("{}: {name} has no number", row.scheme));
        }
    }
    Outcome {
        left: match row.method {
            None => {
                let points = answer["points"].as_u64().unwrap();
                format!("{points} points, rms {:.2} µm", answer["rms_um"].as_f64().unwrap())
            }
            Some(_) => noises(&answer),
        },
        numbers: numbers.len(),
        worst_u,
        wanted,
    }
}

/// What the residuals of a method come to, or how much else it gives.
fn noises(findings: &Value) -> String {
    let values = findings["values"].as_array().unwrap();
    let noise = |value: &&Value| value["name"].as_str().unwrap().starts_with("noise of a reading");
    let noises: Vec<String> = values
        .iter()
        .filter(noise)
        .map(|value| format!("{:.2} µm", value["value"].as_f64().unwrap()))
        .collect();
    match noises.is_empty() {
        true => format!("{} values in all", values.len()),
        false => format!("noise of a reading {}", noises.join(", ")),
    }
}

/// One line of the table.
fn line(row: &Row, outcome: &Outcome) -> String {
    let model = row.model.map_or(String::new(), |model| format!(" --model config/models/{model}.toml"));
    let method = row.method.map_or(String::new(), |method| format!(" --method {method}"));
    let command = format!(
        "`trunnion simulate config/truths/{}.toml --cycle config/cycles/{}.toml -o run.mcap`<br>`trunnion identify run.mcap{model}{method}`",
        row.truth, row.cycle
    );
    let largest = |unit: &str| {
        outcome
            .wanted
            .iter()
            .filter(|found| found.unit == unit)
            .map(|found| found.u)
            .fold(None, |most: Option<f64>, u| Some(most.map_or(u, |most| most.max(u))))
    };
    let u: Vec<String> = [("um", "µm"), ("urad", "µrad"), ("um/m", "µm/m")]
        .into_iter()
        .filter_map(|(unit, shown)| Some(format!("u ≤ {:.2} {shown}", largest(unit)?)))
        .collect();
    format!(
        "| {} | {} | {command} | {} | {} | {} numbers of the machine, all within {ALLOWED_U} u of the injected value, worst {:.1} u | {}; {} |\n",
        row.scheme,
        row.source,
        row.identifies.join(", "),
        row.cannot,
        outcome.numbers,
        outcome.worst_u,
        u.join(", "),
        outcome.left,
    )
}

const DOCUMENT: &str = "docs/measured/schemes.md";

#[test]
fn every_scheme_finds_what_was_injected_and_names_what_is_not_observable() {
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = Vec::new();
    let lines: String = rows().map(|row| line(row, &run(row, folder.path(), &mut wrong))).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let path = workspace_root().join(DOCUMENT);
    let document = std::fs::read_to_string(&path).unwrap();
    let section = Section::of(&document, "rows").unwrap();
    if is_writing() {
        std::fs::write(&path, section.with(&lines)).unwrap();
        return;
    }
    // Figures may differ in the last digit between processors; all else must be current.
    let words = |table: &str| -> Vec<String> {
        table.lines().map(|line| line.split('|').take(6).collect::<Vec<_>>().join("|")).collect()
    };
    assert_eq!(words(section.inside), words(&lines), "{DOCUMENT}: run this test with TRUNNION_WRITE_DOCS=1");
}

/// Stations a millimetre off their places bend the prediction by more than the noise: no excuse to claim an effect.
#[test]
fn a_volume_that_the_model_describes_shows_nothing_missing() {
    let folder = tempfile::tempdir().unwrap();
    let (truth, cycle) = (config("truths", "table-bc-linear"), config("cycles", "tracker"));
    trunnion(folder.path(), &["simulate", &truth, "--cycle", &cycle, "-o", "t.mcap"]);
    let model = config("models", "volume-bc");
    let text = trunnion(folder.path(), &["diagnose", "t.mcap", "--model", &model, "--json"]);
    let answer: Value = serde_json::from_str(&text).unwrap();
    let verdict = answer["verdict"].as_str().unwrap();
    assert!(["noise-floor", "undecided"].contains(&verdict), "{text}");
}
