//! The live path at full rate for a short while; `docs/measured/load.md` has the long one, of an optimised build.

use std::process::Command;

/// Exit code of the trial when something was lost and every sample of it is recorded as lost.
const LOST_AND_TOLD: i32 = 3;

#[test]
fn three_probes_at_4_khz_an_encoder_at_1_khz_and_axes_at_200_hz_lose_nothing_in_silence() {
    let trial = Command::new(env!("CARGO_BIN_EXE_load-trial")).args(["--seconds", "20"]).output().unwrap();
    // Without optimisation, or beside other work, a small computer may leave bytes on the lines longer than they hold them.
    let told = trial.status.success() || trial.status.code() == Some(LOST_AND_TOLD);
    let words = String::from_utf8_lossy(&trial.stdout) + String::from_utf8_lossy(&trial.stderr);
    assert!(told, "{words}");
}
