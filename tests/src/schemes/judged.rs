//! The numbers of an identification against the injected values. The end-to-end test of the schemes takes this file in by its path.

use super::carried::carried;
use serde_json::Value;
use std::collections::BTreeMap;

/// One number of the machine next to what it should be, screen units.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Name as sentences use it.
    pub name: String,
    /// Unit of value and u.
    pub unit: String,
    /// What was identified.
    pub value: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// The injected value, with what convention adds to it.
    pub expected: f64,
}

/// Injected values by name of the parameter, screen units, from the text of a truth file; `also`: what that does not say by itself.
///
/// # Panics
/// When this is no truth file of linear errors.
pub fn injected(truth: &str, also: &[(&str, f64)]) -> BTreeMap<String, f64> {
    let file: toml::Table = truth.parse().unwrap();
    let number = |value: &toml::Value| value.as_float().unwrap();
    let mut injected = BTreeMap::new();
    for (key, value) in file["location"].as_table().unwrap() {
        injected.insert(key.split('_').next().unwrap().to_string(), number(value));
    }
    for hidden in file.get("hidden").and_then(|h| h.as_array()).into_iter().flatten() {
        let size = number(&hidden["amplitude"]) * 1e6 * hidden["shape"].get("sign").map_or(1.0, number);
        let id = hidden["id"].as_str().unwrap();
        let name = match id {
            "squareness:XY" => "EC0Y".into(),
            "squareness:ZX" => "EB0Z".into(),
            "squareness:YZ" => "EA0Z".into(),
            _ => format!("{id}.scale"),
        };
        injected.insert(name, size);
    }
    injected.extend(also.iter().map(|(name, value)| (name.to_string(), *value)));
    injected
}

/// Every number of the machine in an identification; settings and forms of artefacts are no part of the machine.
///
/// # Panics
/// When this is no identification in JSON.
pub fn found(identification: &Value, injected: &BTreeMap<String, f64>) -> Vec<Found> {
    let true_value = |name: &str| injected.get(name).copied().unwrap_or(0.0);
    let of_machine =
        |parameter: &&Value| parameter["effect"] != "ball-setting" && parameter["effect"] != "artefact-form";
    let one = |parameter: &Value| {
        let (value, u) = parameter["value"].as_f64().zip(parameter["u"].as_f64())?;
        let name = name_of(parameter);
        let expected = true_value(&name) + carried(identification, &name, &true_value);
        Some(Found { unit: parameter["unit"].as_str().unwrap().into(), name, value, u, expected })
    };
    identification["parameters"].as_array().unwrap().iter().filter(of_machine).filter_map(one).collect()
}

/// Names as sentences use them: `scale` alone says nothing.
fn name_of(parameter: &Value) -> String {
    let name = parameter["name"].as_str().unwrap();
    if name == "scale" { format!("{}.scale", parameter["effect"].as_str().unwrap()) } else { name.into() }
}
