//! From a confused diagnosis to the cycle that settles it, measured on the virtual machine.

use serde_json::Value;
use std::path::Path;

/// Runs `trunnion` in a folder, expects exit 0, gives standard output.
fn trunnion(folder: &Path, args: &[&str]) -> String {
    let output = crate::program::command().current_dir(folder).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&trunnion(folder, args)).unwrap()
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

/// A machine with ordinary errors and noise, and one thing hidden.
fn truth(hidden: &str) -> String {
    format!(
        r#"format = "trunnion-truth/1"
machine = "table-bc"
seed = "11"
run_duration_s = 1700.0

[location]
EX0C_um = 8.0
EY0C_um = -5.0
EX0B_um = -6.0
EA0B_urad = 30.0

[noise]
white_um = 0.3
pass_offset_um = 0.1
drift_um = 0.15
drift_time_s = 400.0
repeatability_urad = 1.0
natural_motion_um = 0.15
outlier_share = 0.01
outlier_um = 5.0

[[setup]]
name = "low"
instrument = "r-test"
nest = "table"
ball_in_table_mm = [150.0, 0.0, 60.0]
setting_um = [12.0, -7.0, 4.0]

{hidden}"#
    )
}

/// C turns at one feed; `passes` says which ways.
fn one_feed(passes: &str) -> String {
    format!(
        r#"format = "trunnion-cycle/1"
name = "one-feed"
machine = "table-bc"
kind = "on-the-fly"
passes = {passes}

[[setup]]
name = "low"
instrument = "r-test"
nest = "table"
ball_in_table_mm = [150.0, 0.0, 60.0]

[sweep]
axis = "C"
from_deg = 0
to_deg = 360
feeds_deg_per_min = [1800]
"#
    )
}

const BACKLASH: &str = "[[hidden]]\nid = \"backlash:C\"\namplitude = 4e-5\nshape = { sign = -1.0 }\n";
const LAG: &str = "[[hidden]]\nid = \"servo-lag:C\"\namplitude = 4e-5\nshape = { sign = 1.0 }\n";

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect()
}

#[test]
fn at_one_feed_backlash_and_lag_are_confused_and_the_planned_cycles_name_the_right_one() {
    for (hidden, right, wrong) in
        [(BACKLASH, "backlash:C", "servo-lag:C"), (LAG, "servo-lag:C", "backlash:C")]
    {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        write(folder, "truth.toml", &truth(hidden));
        write(folder, "first.toml", &one_feed(r#"["+", "-"]"#));
        trunnion(folder, &["simulate", "truth.toml", "--cycle", "first.toml", "-o", "0.mcap"]);
        let mut runs = vec!["0.mcap".to_string()];
        let mut diagnosis = diagnose(folder, &runs);
        let rivals = confused(&diagnosis);
        assert!(rivals.contains(&right.into()) && rivals.contains(&wrong.into()), "{rivals:?}");

        // Each cycle settles what it can; a second one whatever only another axis can tell.
        for round in ["1", "2", "3"] {
            if confused(&diagnosis).len() < 2 {
                break;
            }
            let (next, run) = (format!("{round}.toml"), format!("{round}.mcap"));
            let mut args = vec!["plan"];
            args.extend(runs.iter().map(String::as_str));
            let plan = json(folder, &[&args[..], &["-o", &next, "--json"]].concat());
            // The diagnosis said as much already.
            assert_eq!(diagnosis["next_cycle"]["cycle"]["name"], plan["next"]["name"], "{diagnosis}");
            assert_eq!(diagnosis["next_cycle"]["suggestion"], plan["answer"], "{diagnosis}");
            let rows = plan["considered"].as_array().unwrap();
            let again = rows.iter().find(|row| row["name"] == "again").unwrap();
            assert!(
                rows[0]["pairs_apart"].as_u64() > again["pairs_apart"].as_u64(),
                "repeating cures none: {plan}"
            );
            trunnion(folder, &["simulate", "truth.toml", "--cycle", &next, "--run", round, "-o", &run]);
            runs.push(run);
            diagnosis = diagnose(folder, &runs);
        }
        assert_eq!(diagnosis["candidates"][0]["effect"], right, "{diagnosis}");
        assert_eq!(confused(&diagnosis), [right], "after {} runs: {diagnosis}", runs.len());
        assert!(diagnosis["next_cycle"]["cycle"].is_null(), "nothing is left to separate: {diagnosis}");
    }
}

/// The first candidate and what it is confused with.
fn confused(diagnosis: &Value) -> Vec<String> {
    let best = &diagnosis["candidates"][0];
    let mut rivals = vec![best["effect"].as_str().unwrap().to_string()];
    rivals.extend(strings(&best["confused_with"]).into_iter().map(String::from));
    rivals
}

fn diagnose(folder: &Path, runs: &[String]) -> Value {
    let mut args = vec!["diagnose"];
    args.extend(runs.iter().map(String::as_str));
    args.push("--json");
    json(folder, &args)
}

#[test]
fn what_one_direction_cannot_show_is_planned_for_and_then_found() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "truth.toml", &truth(BACKLASH));
    write(folder, "first.toml", &one_feed(r#"["+"]"#));
    trunnion(folder, &["simulate", "truth.toml", "--cycle", "first.toml", "-o", "first.mcap"]);
    let first = json(folder, &["diagnose", "first.mcap", "--json"]);
    assert_eq!(first["candidates"].as_array().unwrap().len(), 0, "{first}");

    let plan = json(
        folder,
        &["plan", "first.mcap", "--rivals", "backlash:C,servo-lag:C", "-o", "next.toml", "--json"],
    );
    assert!(plan["next"]["separation_after"].as_f64().unwrap() > 3.0, "{plan}");
    trunnion(folder, &["simulate", "truth.toml", "--cycle", "next.toml", "--run", "1", "-o", "next.mcap"]);
    let both = json(folder, &["diagnose", "first.mcap", "next.mcap", "--json"]);
    assert_eq!(both["candidates"][0]["effect"], "backlash:C", "{both}");

    // Without names the plan is for what the cycle hides.
    let plan = json(folder, &["plan", "first.mcap", "--json"]);
    assert_eq!(plan["goal"], "reveal");
    let rows = plan["considered"].as_array().unwrap();
    let shown = |row: &Value| strings(&row["shows"]).len();
    let again = rows.iter().find(|row| row["name"] == "again").unwrap();
    assert!(shown(&rows[0]) > 10 + shown(again), "{plan}");
    let turn = rows.iter().find(|row| row["name"] == "turn").unwrap();
    assert!(strings(&turn["shows"]).contains(&"backlash:C"), "{turn}");
}

#[test]
fn wind_up_under_gravity_and_an_eccentric_encoder_part_only_under_another_load() {
    // Wind-up of the drive of B is a first harmonic of its positioning error, whatever the axes do.
    let wind_up = "[[hidden]]\nid = \"gravity-sag:B\"\namplitude = 1.0\n[hidden.shape]\nacross = 0.0\nalong = 0.0\n\
        upright = 0.0\nacross_upright = 0.0\nwindup_rad_per_mm = 4e-5\nwindup_phase_rad = 0.4\n";
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "truth.toml", &truth(wind_up));
    trunnion(folder, &["simulate", "truth.toml", "-o", "first.mcap"]);
    let plan = json(
        folder,
        &[
            "plan",
            "first.mcap",
            "--rivals",
            "gravity-sag:B,encoder-eccentricity:B",
            "-o",
            "next.toml",
            "--json",
        ],
    );
    assert!(plan["next"].is_null() && !folder.join("next.toml").exists(), "{plan}");
    assert!(plan["answer"].as_str().unwrap().contains("another load"), "{plan}");
    for row in plan["considered"].as_array().unwrap() {
        assert!(row["separation"].as_f64().unwrap() < 1.5, "{row}");
    }
}

#[test]
fn before_measuring_the_grid_of_oyama_is_known_to_hide_and_to_mix() {
    let folder = tempfile::tempdir().unwrap();
    let cycle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/cycles/r-test-static.toml");
    let preview = json(folder.path(), &["plan", "--cycle", cycle, "--json"]);
    let ids = |key: &str| -> Vec<String> {
        let list = preview[key].as_array().unwrap();
        list.iter().map(|entry| entry["effect"].as_str().unwrap().to_string()).collect()
    };
    assert!(ids("out_of_reach").contains(&"servo-lag:C".to_string()), "{preview}");
    // docs/design/statistics.md §4.4: sag that twists B is the first harmonic of B's encoder; on a 30° grid n = 11 of C reads as 1.
    let alias = |one: &str, other: &str| {
        preview["aliases"].as_array().unwrap().iter().find(|alias| {
            let (a, b) = (alias["one"].as_str().unwrap(), alias["other"].as_str().unwrap());
            (a.starts_with(one) && b.starts_with(other)) || (a.starts_with(other) && b.starts_with(one))
        })
    };
    let sag = alias("gravity-sag:B", "encoder-eccentricity:B").expect("an alias");
    assert!(sag["separated_by"].is_null(), "{sag}");
    let teeth = alias("encoder-eccentricity:C", "drive-pitch:C").expect("an alias");
    assert!(teeth["separated_by"].is_object(), "{teeth}");
}
