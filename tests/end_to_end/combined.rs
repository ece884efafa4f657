//! Three instruments on one machine: an R-test, a ball-bar and a tracker run in one fit say more than each alone.

use crate::program::trunnion;
use serde_json::Value;
use std::path::Path;

/// What the truth file holds of the parameters that are observable, screen units.
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

fn simulate(folder: &Path, cycle: &str) -> String {
    let run = folder.join(format!("{cycle}.mcap")).display().to_string();
    let (truth, cycle) =
        (root("config/truths/table-bc-linear.toml"), root(&format!("config/cycles/{cycle}.toml")));
    trunnion(&["simulate", &truth, "--cycle", &cycle, "-o", &run]);
    run
}

fn identify(runs: &[&str], model: &str) -> Value {
    let model = root(&format!("config/models/{model}.toml"));
    let args = [&["identify"], runs, &["--model", &model, "--notation", "absolute", "--json"]].concat();
    serde_json::from_str(&trunnion(&args)).unwrap()
}

/// Value and standard uncertainty; `None` when it is not observable.
fn found(fit: &Value, effect: &str, name: &str) -> Option<(f64, f64)> {
    let parameters = fit["parameters"].as_array().unwrap();
    let parameter = parameters.iter().find(|p| p["effect"] == effect && p["name"].as_str() == Some(name))?;
    parameter["value"].as_f64().zip(parameter["u"].as_f64())
}

/// The same of a location error in the machine coordinate system.
fn located(fit: &Value, symbol: &str) -> Option<(f64, f64)> {
    let errors = fit["location_errors"]["values"].as_array().unwrap();
    let error = errors.iter().find(|error| error["symbol"] == symbol)?;
    error["value"].as_f64().zip(error["u"].as_f64())
}

#[test]
fn r_test_ball_bar_and_tracker_together_know_every_parameter_better_than_each_alone() {
    let folder = tempfile::tempdir().unwrap();
    // At rest, on the fly, at rest.
    let [r_test, ball_bar, tracker] =
        ["r-test-static", "bk2-c", "tracker"].map(|c| simulate(folder.path(), c));
    let together = identify(&[&r_test, &ball_bar, &tracker], MODEL);
    let alone = [&r_test, &ball_bar, &tracker].map(|run| identify(&[run], MODEL));
    let (mut compared, mut squares) = ([0; 3], 0.0);
    let mut better = |run: usize, what: &str, u: f64, u_alone: Option<f64>| {
        if let Some(u_alone) = u_alone {
            assert!(u < u_alone, "{what}: {u} together, {u_alone} by {}", alone[run]["runs"]);
            compared[run] += 1;
        }
    };
    for (effect, name, truth) in TRUTH {
        let (value, u) =
            found(&together, effect, name).unwrap_or_else(|| panic!("{effect} {name} has no number"));
        assert!((value - truth).abs() <= 3.0 * u, "{effect} {name}: {value} ± {u} is not {truth}");
        squares += ((value - truth) / u).powi(2);
        for run in [0, 2] {
            better(run, name, u, found(&alone[run], effect, name).map(|(_, u)| u));
        }
    }
    // χ² of 14 degrees of freedom: the uncertainties as a whole are right (0.1 % and 99.9 %).
    assert!((3.0..36.1).contains(&squares), "χ² {squares}");
    // B is at rest under the ball bar: what it knows of C is the line in the machine.
    for symbol in ["EA0C", "EB0C", "EC0Y"] {
        let (_, u) = located(&together, symbol).unwrap();
        better(1, symbol, u, located(&alone[1], symbol).map(|(_, u)| u));
    }
    // The R-test sees all but the scales, the tracker the linear axes.
    assert_eq!(compared, [11, 3, 6]);
    // Setups of one name in different runs stay apart.
    let names: Vec<&str> =
        together["parameters"].as_array().unwrap().iter().filter_map(|p| p["name"].as_str()).collect();
    assert!(["1.low", "2.radial", "3.ne"].iter().all(|setup| names.iter().any(|name| name.contains(setup))));
}
