//! Three instruments on one machine: an R-test, a ball-bar and a tracker run in one fit say more than each alone.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What the truth file holds of the parameters that can be told, screen units.
const TRUTH: [(&str, &str, f64); 14] = [
    ("location-errors", "EX0B", 8.0),
    ("location-errors", "EZ0B", -6.0),
    ("location-errors", "EA0B", 25.0),
    ("location-errors", "EB0B", -30.0),
    ("location-errors", "EC0B", 18.0),
    ("location-errors", "EX0C", -12.0),
    ("location-errors", "EY0C", 9.0),
    ("location-errors", "EA0C", 40.0),
    ("squareness:YX", "EC0Y", 30.0),
    ("squareness:ZX", "EB0Z", -20.0),
    ("squareness:ZY", "EA0Z", 25.0),
    ("linear-scale:X", "scale", 15.0),
    ("linear-scale:Y", "scale", -10.0),
    ("linear-scale:Z", "scale", 0.0),
];

/// One model for every fit: with fewer errors a run would know the rest better than it can.
const MODEL: &str = "straight-lines-bc";

fn root(path: &str) -> String {
    format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Expects exit 0, gives standard output.
fn trunnion(args: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_trunnion")).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn simulate(folder: &Path, cycle: &str) -> String {
    let run = folder.join(format!("{cycle}.mcap")).display().to_string();
    let (truth, cycle) =
        (root("config/truths/table-bc-linear.toml"), root(&format!("config/cycles/{cycle}.toml")));
    trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    run
}

fn identify(runs: &[&str], model: &str) -> Value {
    let model = root(&format!("config/models/{model}.toml"));
    let args = [&["identify"], runs, &["--model", &model, "--json"]].concat();
    serde_json::from_str(&trunnion(&args)).unwrap()
}

/// Value and standard uncertainty; `None` when it cannot be seen.
fn found(fit: &Value, effect: &str, name: &str) -> Option<(f64, f64)> {
    let parameters = fit["parameters"].as_array().unwrap();
    let parameter = parameters.iter().find(|p| p["effect"] == effect && p["name"].as_str() == Some(name))?;
    parameter["value"].as_f64().zip(parameter["u"].as_f64())
}

#[test]
fn r_test_ball_bar_and_tracker_together_know_every_parameter_better_than_each_alone() {
    let folder = tempfile::tempdir().unwrap();
    // At rest, on the fly, at rest.
    let [r_test, ball_bar, tracker] =
        ["r-test-static", "bk2-c", "tracker"].map(|c| simulate(folder.path(), c));
    let together = identify(&[&r_test, &ball_bar, &tracker], MODEL);
    let alone = [&r_test, &ball_bar, &tracker].map(|run| identify(&[run], MODEL));
    let mut compared = [0; 3];
    for (effect, name, truth) in TRUTH {
        let (value, u) =
            found(&together, effect, name).unwrap_or_else(|| panic!("{effect} {name} has no number"));
        assert!((value - truth).abs() <= 2.0 * u, "{effect} {name}: {value} ± {u} is not {truth}");
        for (fit, count) in alone.iter().zip(&mut compared) {
            if let Some((_, u_alone)) = found(fit, effect, name) {
                assert!(u < u_alone, "{effect} {name}: {u} together, {u_alone} by {}", fit["runs"]);
                *count += 1;
            }
        }
    }
    // The R-test sees all but the scales, the ball bar C and the squareness of X and Y, the tracker the linear axes; only together
    // they see all.
    let [r_test, ball_bar, tracker] = compared;
    assert!(r_test >= 11 && ball_bar >= 2 && tracker >= 6, "{compared:?}");
    assert!(r_test < TRUTH.len() && ball_bar < TRUTH.len() && tracker < TRUTH.len(), "{compared:?}");
    // Setups of one name in different runs stay apart.
    let names: Vec<&str> =
        together["parameters"].as_array().unwrap().iter().filter_map(|p| p["name"].as_str()).collect();
    assert!(["1.low", "2.radial", "3.ne"].iter().all(|setup| names.iter().any(|name| name.contains(setup))));
}
