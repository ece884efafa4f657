//! A spindle that is a joint: its line is found where it is indexed, and only there.

use crate::one_line;
use crate::section::workspace_root;
use serde_json::Value;
use std::path::Path;
use std::process::Output;

/// Location errors of the line of the spindle [S2 tables 2-3].
const OF_SPINDLE: [&str; 4] = ["EX0C1", "EY0C1", "EA0C1", "EB0C1"];
const GRID: &str = "\n[[grid]]\naxis = \"C1\"\nstations_deg = [0, 90, 180, 270]\n";

fn answer(folder: &Path, args: &[&str]) -> Output {
    crate::program::command().current_dir(folder).args(args).output().unwrap()
}

fn trunnion(folder: &Path, args: &[&str]) -> String {
    let output = answer(folder, args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn config(kind: &str, name: &str) -> String {
    workspace_root().join(format!("config/{kind}/{name}.toml")).display().to_string()
}

fn shipped_cycle() -> String {
    std::fs::read_to_string(config("cycles", "r-test-head-bc-spindle")).unwrap()
}

/// Simulates a cycle given as text on the shipped truth.
fn simulated(folder: &Path, cycle: &str) {
    std::fs::write(folder.join("cycle.toml"), cycle).unwrap();
    let truth = config("truths", "head-bc-spindle");
    trunnion(folder, &["simulate", &truth, "--cycle", "cycle.toml", "-o", "run.mcap"]);
}

fn identified(folder: &Path, run: &str) -> Value {
    serde_json::from_str(&trunnion(folder, &["identify", run, "--json"])).unwrap()
}

/// Value and u of a parameter that has a number.
fn number(answer: &Value, name: &str) -> Option<(f64, f64)> {
    let all = answer["parameters"].as_array().unwrap();
    let one = all.iter().find(|parameter| parameter["name"] == name)?;
    one["value"].as_f64().zip(one["u"].as_f64())
}

#[test]
fn a_spindle_that_is_not_indexed_gets_no_line_and_the_answer_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at_rest = shipped_cycle().replace(GRID, "");
    assert!(at_rest.len() < shipped_cycle().len());
    simulated(folder.path(), &at_rest);
    let answer = identified(folder.path(), "run.mcap");
    let unseen = answer["unobservable"].to_string();
    for name in OF_SPINDLE {
        assert_eq!(number(&answer, name), None, "{name} cannot be separated from the ball off the spindle");
        assert!(unseen.contains(name), "{name}: {unseen}");
    }
    assert!(unseen.contains("axis C1 is at rest"), "{unseen}");
}

#[test]
fn points_with_the_angle_of_the_spindle_lose_nothing_on_their_way_through_a_table() {
    let folder = tempfile::tempdir().unwrap();
    simulated(folder.path(), &shipped_cycle());
    let recorded = identified(folder.path(), "run.mcap");
    let table = trunnion(folder.path(), &["export", "csv", "run.mcap", "--what", "points"]);
    assert!(table.lines().next().unwrap().contains("c1_deg"), "{}", &table[..200]);
    std::fs::write(folder.path().join("points.csv"), table).unwrap();
    let setup = shipped_cycle();
    let setups = &setup[setup.find("[[setup]]").unwrap()..setup.find("[[grid]]").unwrap()];
    let setup = format!("format = \"trunnion-points/1\"\nmachine = \"head-bc-spindle\"\n{setups}");
    std::fs::write(folder.path().join("setup.toml"), setup).unwrap();
    trunnion(folder.path(), &["import", "points.csv", "--setup", "setup.toml", "-o", "again.mcap"]);
    let imported = identified(folder.path(), "again.mcap");
    for name in OF_SPINDLE {
        let ((value, u), (again, _)) = (number(&recorded, name).unwrap(), number(&imported, name).unwrap());
        assert!((value - again).abs() < 0.1 * u, "{name}: {value}, imported {again} ± {u}");
    }
}

#[test]
fn the_line_of_the_spindle_is_in_the_vectors_and_its_lean_is_named() {
    let folder = tempfile::tempdir().unwrap();
    simulated(folder.path(), &shipped_cycle());
    let written = trunnion(folder.path(), &["correct", "run.mcap", "--control", "siemens", "-o", "file.mpf"]);
    assert!(written.contains("Not in it: lean of the tool, "), "{written}");
    let refused =
        answer(folder.path(), &["correct", "run.mcap", "--control", "heidenhain", "-o", "file.txt"]);
    let said = one_line(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(said.contains("EX0C1") && said.contains("side of the tool are not public"), "{said}");
    let taken = trunnion(folder.path(), &["correct", "run.mcap", "--control", "linuxcnc", "-o", "file.comp"]);
    assert!(taken.contains("holds the corrections of C, B, C1"), "{taken}");
}

#[test]
fn what_turns_the_spindle_by_hand_has_no_program() {
    let folder = tempfile::tempdir().unwrap();
    let cycle = config("cycles", "r-test-head-bc-spindle");
    let output = answer(folder.path(), &["nc-program", &cycle, "--dialect", "linuxcnc"]);
    let said = one_line(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("programs move X Y Z A B C, and it turns another joint"), "{said}");
}
