//! Configurations of three simulated optoNCDT probes in an orthogonal nest.

use std::path::Path;
use trunnion_hil_sim::devices::orthogonal_nest;

/// For tests that do not judge time: simulated devices share a computer with whatever else runs on it, and may pause.
pub const SILENCE_MS: u32 = 3000;

/// What a configuration begins with, but for its tables.
pub fn head(recordings: &str) -> String {
    format!(
        "format = \"trunnion-config/1\"\nname = \"m\"\ncycle = \"c.toml\"\nrecordings = \"{recordings}\"\n"
    )
}

/// The table of the nest.
pub fn nest() -> String {
    let row = |(k, direction): (usize, &[f64; 3])| format!("probe_{} = {direction:?}\n", k + 1);
    let rows: String = orthogonal_nest().iter().enumerate().map(row).collect();
    format!("[nest]\n{rows}")
}

/// The tables of the probes on ports of this folder, silent after `silence_ms`.
pub fn devices(ports: &Path, silence_ms: u32) -> String {
    let one = |k| {
        format!(
            "[[device]]\nname = \"probe-{k}\"\ndriver = \"optoncdt\"\nport = '{}/probe-{k}'\nrole = \"probe-{k}\"\nrange_mm = 2\n\
             silence_ms = {silence_ms}\n",
            ports.display()
        )
    };
    (1..=3).map(one).collect()
}
