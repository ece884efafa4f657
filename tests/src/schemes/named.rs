//! The numbers of a named method against the injected values. The end-to-end test of the schemes takes this file in by its path.

use super::judged::Found;
use super::rows::Row;
use super::volumetric;
use serde_json::Value;
use std::collections::BTreeMap;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::Truth;

/// Every number that the row identifies next to what it should be; of multilateration the errors of all targets.
///
/// # Panics
/// When these are no findings of the row's method in JSON, or the truth is of another machine.
pub fn found(
    row: &Row,
    findings: &Value,
    cycle: &Cycle,
    truth: &Truth,
    injected: &BTreeMap<String, f64>,
) -> Vec<Found> {
    if row.method == Some("multilateration") {
        return volumetric::found(findings, cycle, truth);
    }
    let with_truth = |number: Number| {
        let injected = injected.get(&number.name).copied().unwrap_or(0.0);
        let expected = match number.name.split_once(' ') {
            Some((_, "time constant")) => time_constant_s(truth),
            Some((_, "change")) => injected * share_gone(findings, truth),
            _ => injected,
        };
        let is_size = row.sizes.contains(&number.name.as_str());
        let expected = if is_size { expected.abs() } else { expected };
        Found { name: number.name, unit: number.unit, value: number.value, u: number.u, expected }
    };
    let numbers = values(findings).chain(harmonics(findings));
    numbers.filter(|number| row.identifies.contains(&number.name.as_str())).map(with_truth).collect()
}

/// Of the machine that warms up, the same whatever the size of its errors.
fn time_constant_s(truth: &Truth) -> f64 {
    let warms = truth.hidden.iter().find(|hidden| hidden.kind.name == "thermal-drift").unwrap();
    let fast = warms.kind.shape.iter().position(|name| *name == "fast_s").unwrap();
    warms.shape[fast]
}

/// The share of its whole way that the machine goes from the mean time of the first round to that of the last, by their times in the table.
fn share_gone(findings: &Value, truth: &Truth) -> f64 {
    let rounds = findings["tables"][0]["rows"].as_array().unwrap();
    let left = |round: &Value| (-round[0].as_f64().unwrap() / time_constant_s(truth)).exp();
    left(&rounds[0]) - left(&rounds[rounds.len() - 1])
}

/// A number with u, screen units.
struct Number {
    name: String,
    unit: String,
    value: f64,
    u: f64,
}

fn values(findings: &Value) -> impl Iterator<Item = Number> {
    findings["values"].as_array().unwrap().iter().filter_map(|value| {
        let text = |key: &str| value[key].as_str().unwrap().to_string();
        let (found, u) = value["value"].as_f64().zip(value["u"].as_f64())?;
        Some(Number { name: text("name"), unit: text("unit"), value: found, u })
    })
}

/// The significant waves of the table of harmonics; each is called by its error motion and its number a turn, `EXC, 3 a turn`.
fn harmonics(findings: &Value) -> impl Iterator<Item = Number> {
    let is_harmonics = |table: &&Value| table["caption"].as_str().unwrap().contains("as harmonics");
    let tables = findings["tables"].as_array().unwrap().iter().filter(is_harmonics);
    tables.flat_map(|table| table["rows"].as_array().unwrap()).filter_map(|row| {
        let text = |k: usize| row[k].as_str().unwrap();
        let number = |k: usize| row[k].as_f64().unwrap();
        let name = format!("{}, {} a turn", text(0), text(1));
        let unit = if text(4) == "µrad" { "urad" } else { "um" };
        let significant = !text(6).contains("not significant");
        significant.then(|| Number { name, unit: unit.into(), value: number(2), u: number(3) })
    })
}
