//! Simulated runs of known moments.

use super::program::trunnion;
use std::path::Path;
use trunnion_machine::shipped;

const TRUTH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/truths/table-bc.toml");

/// Run number `number` of the machine whose truth is that of the shipped file after `change`, begun at `began_ns` since 1970.
pub fn simulate(folder: &Path, name: &str, number: usize, began_ns: i64, change: impl Fn(String) -> String) {
    let truth = change(std::fs::read_to_string(TRUTH).unwrap());
    let elsewhere = tempfile::tempdir().unwrap();
    let file = elsewhere.path().join("truth.toml").display().to_string();
    std::fs::write(&file, truth).unwrap();
    let undated = elsewhere.path().join(name);
    trunnion(&["simulate", &file, "--run", &number.to_string(), "-o", &undated.display().to_string()]);
    let recording = trunnion_record::read_run(&undated, &shipped::machine).unwrap();
    let header = trunnion_record::RunHeader { wall_start_ns: began_ns, ..recording.header };
    trunnion_record::write_run(&folder.join(name), &header, &recording.run).unwrap();
}
