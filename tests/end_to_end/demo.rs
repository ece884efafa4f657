//! The main job through real ports: virtual probes and controller, real drivers, recording, diagnosis.

use serde_json::Value;
use std::process::Command;

#[test]
fn the_demo_finds_the_hidden_sag_and_replay_repeats_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("demo").display().to_string();
    let trunnion = |args: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_trunnion")).args(args).output().unwrap();
        (done.status.code(), String::from_utf8(done.stdout).unwrap(), String::from_utf8(done.stderr).unwrap())
    };
    let (code, stdout, stderr) =
        trunnion(&["demo", "--hidden", "gravity-sag:B", "--seed", "7", "--json", "--output", &output]);
    // A busy machine may lose samples: that is reported (exit 3) and is no failure of the diagnosis.
    assert!(matches!(code, Some(0 | 3)), "{stderr}");
    let reported: Value = serde_json::from_str(&stdout).unwrap();
    let losses: Vec<&str> = reported["losses"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(code == Some(0), losses.is_empty(), "{losses:?}");
    // The reason is said with the pause that was measured.
    let why_lost = reported["why_lost"].as_str().unwrap();
    assert_eq!(why_lost.is_empty(), losses.is_empty(), "{why_lost}");
    assert!(
        losses.is_empty() || (why_lost.starts_with("Data loss") && why_lost.contains(" ms")),
        "{why_lost}"
    );
    // While the ball is mounted again the probes are out of range, and before the program starts nothing is asked.
    assert!(losses.iter().all(|loss| !loss.contains("range") && !loss.contains("from -")), "{losses:?}");
    assert_eq!(reported["diagnosis"]["candidates"][0]["effect"], "gravity-sag:B", "{reported}");
    let step = &reported["ladder"][0];
    let number = |key: &str| step[key].as_f64().unwrap();
    assert!(number("error_after_um") < 0.5 * number("error_before_um"), "{step}");
    assert!(number("holdout_after_um") < 0.7 * number("holdout_before_um"), "{step}");

    // The page of a recording looks for its model here.
    let files = |name: &str| folder.path().join("demo").join(name).exists();
    assert!(files("static.model.toml") && !files("model.toml"));

    // From the file alone comes what the live run said.
    let run = format!("{output}/static.mcap");
    let (_, replayed, _) = trunnion(&["diagnose", &run, "--json"]);
    let replayed: Value = serde_json::from_str(&replayed).unwrap();
    assert_eq!(replayed, reported["diagnosis"]);
    let page = std::fs::read_to_string(format!("{output}/report.html")).unwrap();
    assert!(page.contains("gravity-sag:B") && page.contains("<svg"));
}
