//! What end-to-end tests share: paths, the log, waiting for a report.

pub mod alignment;
pub mod baselines;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod carried;
pub mod convergence;
pub mod in_turn;
pub mod log;
pub mod mosquitto;
pub mod page_status;
pub mod peer;
pub mod schemes;
pub mod section;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod sweeps;

pub use section::workspace_root;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_hil_sim::devices::orthogonal_nest;
pub use trunnion_hil_sim::pauses;

/// What the program logs is shown when a test fails.
pub fn show_log() {
    let level = tracing_subscriber::filter::LevelFilter::INFO;
    // Another test of the same process may have done it.
    drop(tracing_subscriber::fmt().with_test_writer().with_max_level(level).try_init());
}

/// Waits until the service has written the report of its first cycle: the recording, next to which the report is; `None` when
/// there is none after `limit`.
pub async fn first_report(recordings: &Path, limit: Duration) -> Option<PathBuf> {
    reports(recordings, 1, limit).await?.pop()
}

/// The same for so many cycles; the recordings in order of their names.
pub async fn reports(recordings: &Path, count: usize, limit: Duration) -> Option<Vec<PathBuf>> {
    let written = async {
        loop {
            let files = std::fs::read_dir(recordings).into_iter().flatten().flatten();
            let names = files.map(|file| file.path().to_string_lossy().into_owned());
            let run =
                |name: String| Some(PathBuf::from(format!("{}.mcap", name.strip_suffix(".diagnosis.json")?)));
            let mut runs: Vec<PathBuf> = names.filter_map(run).collect();
            runs.sort();
            if runs.len() >= count {
                return runs;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    };
    tokio::time::timeout(limit, written).await.ok()
}

/// For tests that do not judge time: simulated devices share a computer with whatever else runs on it, and may pause.
pub const SILENCE_MS: u32 = 3000;

/// A configuration of three optoNCDT probes on ports of this folder in an orthogonal nest, silent after `silence_ms`; `tables` stand
/// before the devices, `controller` is the table of the controller.
pub fn three_probes(ports: &Path, silence_ms: u32, tables: &str, controller: &str) -> String {
    let mut text = format!(
        "format = \"trunnion-config/1\"\nname = \"m\"\ncycle = \"c.toml\"\nrecordings = \"runs\"\n{tables}[nest]\n"
    );
    for (k, direction) in orthogonal_nest().iter().enumerate() {
        text += &format!("probe_{} = {direction:?}\n", k + 1);
    }
    for k in 1..=3 {
        text += &format!(
            "[[device]]\nname = \"probe-{k}\"\ndriver = \"optoncdt\"\nport = '{}/probe-{k}'\nrole = \"probe-{k}\"\nrange_mm = 2\n\
             silence_ms = {silence_ms}\n",
            ports.display()
        );
    }
    text + controller
}
