//! Points from an independent simulator, through the binary: import, diagnose, add.

use crate::program::{data, import, json, trunnion};
use serde_json::Value;
#[test]
fn gravity_is_named_first_and_adding_it_lowers_the_error_also_on_held_out_passes() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let diagnosis = json(&["diagnose", &run, "--json"]);
    assert_eq!(diagnosis["verdict"], "missing-effect");
    assert_eq!(diagnosis["candidates"][0]["effect"], "gravity-sag:B");

    let model = folder.path().join("model.toml").display().to_string();
    let added = json(&["add", "gravity-sag:B", &run, "--model", &model, "--json"]);
    let number = |key: &str| added[key].as_f64().unwrap();
    assert!(number("error_after_um") < 1.3 * number("noise_um"), "{added}");
    assert!(number("holdout_after_um") < 0.6 * number("holdout_before_um"), "{added}");
    assert!(trunnion(&["ladder", "--model", &model]).contains("gravity-sag:B"));
    // What is left is noise, and the model file that a person can read says so.
    assert_eq!(json(&["diagnose", &run, "--model", &model, "--json"])["verdict"], "noise-floor");
}

#[test]
fn backlash_and_drift_are_found_by_two_adds() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-backlash-and-drift", folder.path());
    let model = folder.path().join("model.toml").display().to_string();
    let mut found = Vec::new();
    let mut diagnosis = json(&["diagnose", &run, "--json"]);
    for _ in 0..2 {
        let effect = diagnosis["candidates"][0]["effect"].as_str().unwrap().to_string();
        trunnion(&["add", &effect, &run, "--model", &model]);
        found.push(effect);
        diagnosis = json(&["diagnose", &run, "--model", &model, "--json"]);
    }
    found.sort();
    assert_eq!(found, ["backlash:C", "thermal-drift"]);
}

#[test]
fn nothing_hidden_is_reported_as_noise_and_the_location_errors_are_those_of_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-nothing-hidden", folder.path());
    let diagnosis = json(&["diagnose", &run, "--json"]);
    assert_eq!(diagnosis["verdict"], "noise-floor");
    assert_eq!(diagnosis["candidates"].as_array().unwrap().len(), 0);

    let truth: Value = serde_json::from_str(
        &std::fs::read_to_string(data("points-nothing-hidden").join("truth.json")).unwrap(),
    )
    .unwrap();
    let identification = json(&["identify", &run, "--json"]);
    for (name, value) in truth["location"].as_object().unwrap() {
        let name = name.trim_end_matches("_relative");
        let found =
            identification["parameters"].as_array().unwrap().iter().find(|p| p["name"] == name).unwrap();
        let scale = if found["unit"] == "um" { 1e3 } else { 1e6 };
        let error = found["value"].as_f64().unwrap() - value.as_f64().unwrap() * scale;
        assert!(error.abs() < 4.0 * found["u"].as_f64().unwrap(), "{name}: {error} {found}");
    }
}

#[test]
fn an_effect_of_no_catalogue_is_not_confidently_misnamed() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-unnamed", folder.path());
    let diagnosis = json(&["diagnose", &run, "--json"]);
    let confident =
        diagnosis["verdict"] == "missing-effect" && diagnosis["candidates"][0]["adequate"].as_bool().unwrap();
    assert!(!confident, "{diagnosis}");
}

#[test]
fn a_replay_writes_the_same_bytes_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    assert_eq!(trunnion(&["replay", &run]), trunnion(&["replay", &run]));
}

#[test]
fn export_gives_the_points_back() {
    let folder = tempfile::tempdir().unwrap();
    let run = import("points-gravity", folder.path());
    let table = trunnion(&["export", "csv", &run]);
    let original = std::fs::read_to_string(data("points-gravity").join("points.csv")).unwrap();
    assert_eq!(table.lines().count(), original.lines().count());
    // first point of the file: dx −21.40, dy 15.10, dz 17.50 µm
    let first = table.lines().nth(1).unwrap();
    assert!(first.contains("-21.4") && first.contains("15.1") && first.contains("17.5"), "{first}");
}
