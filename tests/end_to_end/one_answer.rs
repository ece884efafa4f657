//! One question has one answer on the command line too: figures of a recording, imported or recorded by a virtual machine, are the
//! same whichever command prints them, as JSON and in the terminal.

use crate::program::{command, data, import, trunnion};
use serde_json::Value;
use std::path::Path;
use trunnion::results::number::um;

/// Two fits of one model may end this share apart.
const SAME: f64 = 1e-6;
/// A model file keeps figures in µm with four decimals.
const KEPT_UM: f64 = 0.5001e-4;

/// An answer of which nothing was kept: commands that take what one of them kept would agree by that.
fn json(args: &[&str]) -> Value {
    let output = command().args(args).env("TRUNNION_CACHE_DIR", "").output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A recording of the virtual machine on the fly.
fn simulate(folder: &Path) -> String {
    let run = folder.join("sweep.mcap").display().to_string();
    let config = |file: &str| data("../../config").join(file).display().to_string();
    let (truth, cycle) = (config("truths/table-bc.toml"), config("cycles/r-test-sweep-c.toml"));
    trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    run
}

/// rms, repeatability and held-out error, where they stand under these names.
fn figures(answer: &Value, names: [&str; 3]) -> [Option<f64>; 3] {
    names.map(|name| answer[name].as_f64())
}

const OF_FIT: [&str; 3] = ["rms_um", "noise_um", "holdout_rms_um"];

fn assert_near(a: [Option<f64>; 3], b: [Option<f64>; 3], within: impl Fn(f64) -> f64, what: &str) {
    for (a, b) in a.into_iter().zip(b) {
        match (a, b) {
            (Some(a), Some(b)) => assert!((a - b).abs() <= within(a), "{what}: {a} and {b}"),
            _ => assert_eq!(a, b, "{what}"),
        }
    }
}

fn assert_same_parameters(a: &Value, b: &Value, what: &str) {
    let (a, b) = (a["parameters"].as_array().unwrap(), b["parameters"].as_array().unwrap());
    assert_eq!(a.len(), b.len(), "{what}");
    for (a, b) in a.iter().zip(b) {
        assert_eq!((&a["name"], &a["unit"]), (&b["name"], &b["unit"]), "{what}");
        let u = a["u"].as_f64().unwrap_or(1.0);
        for key in ["value", "u"] {
            match (a[key].as_f64(), b[key].as_f64()) {
                (Some(x), Some(y)) => {
                    assert!((x - y).abs() <= 1e-4 * u, "{what}: {} {key} {x} and {y}", a["name"])
                }
                (x, y) => assert_eq!(x, y, "{what}: {} {key}", a["name"]),
            }
        }
    }
}

#[test]
fn every_command_prints_the_same_figures_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let imported = import("points-gravity", folder.path());
    for run in [imported, simulate(folder.path())] {
        let model = format!("{run}.toml");
        let fit = json(&["identify", &run, "--json"]);
        let diagnosis = json(&["diagnose", &run, "--json"]);
        let compared = json(&["compare", &run, "--json"]);
        let of_fit = figures(&fit, OF_FIT);
        assert!(of_fit.iter().all(Option::is_some), "{run}: {of_fit:?}");
        assert_eq!(of_fit, figures(&diagnosis["residual"], OF_FIT), "{run}: identify, diagnose");
        assert_eq!(of_fit, figures(&compared["identification"], OF_FIT), "{run}: identify, compare");
        assert_eq!(of_fit, figures(&compared["diagnosis"]["residual"], OF_FIT), "{run}: compare, diagnosis");
        assert_eq!(fit["parameters"], compared["identification"]["parameters"], "{run}: identify, compare");
        for command in ["identify", "diagnose"] {
            let text = trunnion(&[command, &run]);
            for figure in of_fit.into_iter().flatten() {
                assert!(text.contains(&um(figure)), "{run}: {command} prints {}: {text}", um(figure));
            }
        }

        let candidate = &diagnosis["candidates"][0];
        let effect = candidate["effect"].as_str().unwrap_or("backlash:C");
        let added = json(&["add", effect, &run, "--model", &model, "--json"]);
        let again = json(&["identify", &run, "--model", &model, "--json"]);
        let of_added = figures(&added["identification"], OF_FIT);
        assert_near(of_added, figures(&again, OF_FIT), |a| SAME * a, &format!("{run}: add, identify"));
        assert_same_parameters(&added["identification"], &again, &format!("{run}: add, identify"));
        let before = figures(&added, ["error_before_um", "noise_um", "holdout_before_um"]);
        assert_near(before, of_fit, |_| KEPT_UM, &format!("{run}: add, identify before"));
        let after = figures(&added, ["error_after_um", "noise_um", "holdout_after_um"]);
        assert_near(after, of_added, |_| KEPT_UM, &format!("{run}: row of add"));
        if candidate["effect"].is_string() {
            let judged = figures(candidate, ["rms_um_after", "none", "holdout_rms_um_after"]);
            let added = [of_added[0], None, of_added[2]];
            assert_near(judged, added, |a| SAME * a, &format!("{run}: candidate, add"));
        }
        let ladder = json(&["ladder", "--model", &model, "--json"]);
        let rows = ladder["rows"].as_array().unwrap();
        let row = &rows.iter().find(|row| row["effect"] == effect).unwrap()["ladder"];
        for key in ["error_before_um", "error_after_um", "holdout_before_um", "holdout_after_um", "noise_um"]
        {
            assert_eq!(row[key], added[key], "{run}: ladder, add: {key}");
        }
    }
}
