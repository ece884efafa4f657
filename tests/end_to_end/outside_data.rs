//! Points from an independent simulator, through the binary: import, diagnose, add.

use crate::program::{data, import, import_and_add, json, trunnion};
use serde_json::Value;
use std::path::Path;
use trunnion::results::{RunAnswer, RunRecord, RunResult, RunState, Verdict};

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

#[test]
fn a_run_is_exported_with_what_a_person_added_and_what_the_service_found() {
    let folder = tempfile::tempdir().unwrap();
    let (run, model) = import_and_add("points-gravity", "gravity-sag:B", folder.path());
    let export = |more: &[&str]| {
        let table = trunnion(&[&["export", "csv", &run, "--what", "runs"], more].concat());
        let lines: Vec<Vec<String>> =
            table.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
        ["effects", "verdict", "missing_effects"]
            .map(|name| lines[1][lines[0].iter().position(|found| found == name).unwrap()].clone())
    };
    let base = "location-errors ball-setting";
    let added = format!("{base} gravity-sag:B");
    let own = Path::new(&run).with_extension("model.toml");
    std::fs::rename(&model, &own).unwrap();
    assert_eq!(export(&[]), [added.as_str(), "", ""], "that of its own model file");
    let record = RunRecord {
        state: RunState::Done,
        answer: Some(RunAnswer {
            result: RunResult {
                verdict: Verdict::MissingEffect,
                missing_effects: vec!["backlash:B".into(), "thermal-drift".into()],
                ..RunResult::default()
            },
            quality: None,
        }),
        ..RunRecord::default()
    };
    trunnion_service::run_record::write(Path::new(&run), &record).unwrap();
    assert_eq!(export(&[]), [added.as_str(), "missing-effect", "backlash:B thermal-drift"]);
    let asked = own.with_file_name("asked.toml");
    std::fs::rename(&own, &asked).unwrap();
    assert_eq!(export(&[]), [base, "missing-effect", "backlash:B thermal-drift"]);
    assert_eq!(
        export(&["--model", asked.to_str().unwrap()]),
        [added.as_str(), "", ""],
        "the fit asked for alone"
    );
}

#[test]
fn what_each_effect_takes_adds_up_to_the_prediction() {
    let folder = tempfile::tempdir().unwrap();
    let (run, model) = import_and_add("points-gravity", "gravity-sag:B", folder.path());
    let export = |what: &str| -> Vec<Vec<String>> {
        let table = trunnion(&["export", "csv", &run, "--model", &model, "--what", what]);
        table.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
    };
    let (by_effect, residuals) = (export("effects"), export("residuals"));
    // The ball is set by hand: its place is confounded with that of the axes, and not with the sag.
    let parts: Vec<&str> = by_effect[1..4].iter().map(|row| row[7].as_str()).collect();
    assert_eq!(parts, ["positions", "location-errors + ball-setting", "gravity-sag:B"]);
    assert_eq!(by_effect.len() - 1, 3 * (residuals.len() - 1));
    let number = |cell: &String| cell.parse::<f64>().unwrap();
    let mut of_sag_um = 0f64;
    for (of_point, residual) in by_effect[1..].chunks(3).zip(&residuals[1..]) {
        assert_eq!(of_point[0][..7], residual[..7]);
        for k in 0..3 {
            let sum_um: f64 = of_point.iter().map(|row| number(&row[8 + k])).sum();
            // Squares of errors of 60 µrad over 300 mm are some nm.
            assert!((sum_um - number(&residual[10 + k])).abs() < 0.01, "{of_point:?} {residual:?}");
            of_sag_um = of_sag_um.max(number(&of_point[2][8 + k]).abs());
        }
    }
    assert!(of_sag_um > 1.0, "{of_sag_um}");
}
