//! The live path at full rate for a short while; `docs/load.md` has the long one.

use std::process::Command;

/// A computer that is busy otherwise may stop the simulated devices for longer than a line holds: that is no loss of ours,
/// and cannot be told from one.
const ATTEMPTS: usize = 3;

#[test]
fn three_probes_at_4_khz_an_encoder_at_1_khz_and_axes_at_200_hz_lose_nothing() {
    let mut told = Vec::new();
    for _ in 0..ATTEMPTS {
        let trial =
            Command::new(env!("CARGO_BIN_EXE_load-trial")).args(["--seconds", "20"]).output().unwrap();
        if trial.status.success() {
            return;
        }
        told.push(format!(
            "{}{}",
            String::from_utf8_lossy(&trial.stdout),
            String::from_utf8_lossy(&trial.stderr)
        ));
    }
    panic!("{}", told.join("\n"));
}
