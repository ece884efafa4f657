//! Every shipped cycle is fitted with and without position scatter; docs/measured/convergence.md has
//! more trials of each, as many as its third column says.

use std::collections::BTreeSet;
use trunnion_tests::convergence::{CASES, trial};
use trunnion_tests::workspace_root;

/// Trials of each cycle; the bin `convergence-trial` does any number.
const TRIALS: u64 = 3;

#[test]
fn scatter_of_positions_changes_neither_what_is_observable_nor_its_value() {
    let mut failed = Vec::new();
    for case in CASES {
        for seed in 0..TRIALS {
            let failures = trial(case, seed);
            failed
                .extend(failures.iter().take(3).map(|failure| format!("{} {seed}: {failure:?}", case.cycle)));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn every_cycle_that_ships_is_tried() {
    let folder = std::fs::read_dir(workspace_root().join("config/cycles")).unwrap();
    let files: BTreeSet<String> =
        folder.map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned()).collect();
    let tried: BTreeSet<String> = CASES.iter().map(|case| case.cycle.to_string()).collect();
    assert_eq!(files, tried);
}
