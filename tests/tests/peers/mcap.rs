//! The MCAP project's own Python reader opens what we record.

use std::process::Command;
use trunnion_core::setup::parse_setup_file;
use trunnion_record::{RunHeader, points_csv, write_run};
use trunnion_tests::peer::peers_python;
use trunnion_tests::workspace_root;

#[test]
#[ignore = "a peer test: tests/peers/run"]
fn the_python_reader_reads_a_recording_with_crcs_index_and_schemas() {
    let folder = tempfile::tempdir().unwrap();
    let data = workspace_root().join("tests/data/points-gravity");
    let setup = std::fs::read_to_string(data.join("setup.toml")).unwrap();
    let setups = parse_setup_file("setup.toml", &setup).unwrap().setups;
    let machine = trunnion_machine::shipped::machine("table-bc").unwrap();
    let points = std::fs::read_to_string(data.join("points.csv")).unwrap();
    let run = points_csv::import("run", "points.csv", &points, setups, machine).unwrap();
    let path = folder.path().join("run.mcap");
    write_run(&path, &RunHeader::of_run(&run, "", "test", 0), &run).unwrap();

    let script = workspace_root().join("tests/peers/mcap_reader.py");
    let output = Command::new(peers_python()).arg(script).arg(&path).output().unwrap();
    let reported = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{reported}{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        reported.lines().any(|line| line.contains("trunnion.Point") && line.ends_with(" 336")),
        "{reported}"
    );
}
