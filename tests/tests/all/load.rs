//! No sample is lost in silence, however slow the computer. What the service does at full rate depends on the computer's speed:
//! `docs/measured/load.md` has the long trial of an optimised build, tests/peers/run a short one.

use std::process::Command;

/// Exit codes of the trial when something was lost and a recorded gap reports every sample: on a computer with time; on a slow one.
const ALL_REPORTED: [i32; 2] = [3, 4];

#[test]
fn every_sample_that_a_silent_probe_did_not_send_is_counted_as_lost() {
    let trial =
        Command::new(env!("CARGO_BIN_EXE_load-trial")).args(["--low", "--seconds", "10"]).output().unwrap();
    let words = String::from_utf8_lossy(&trial.stdout) + String::from_utf8_lossy(&trial.stderr);
    assert!(trial.status.code().is_some_and(|code| ALL_REPORTED.contains(&code)), "{words}");
    // A second at 500 Hz, and nothing else of that probe is missing on a computer with time.
    let row = words.lines().find(|line| line.starts_with("| probe-2 |")).expect(&words);
    let missing: u64 = row.split('|').nth(4).expect(row).trim().parse().unwrap();
    assert!(missing >= 490, "{words}");
}
