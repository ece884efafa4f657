//! What end-to-end tests share: paths, the log, waiting for a report.

pub mod alignment;
pub mod baselines;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod carried;
pub mod convergence;
pub mod course;
pub mod in_turn;
pub mod json_schema;
pub mod log;
pub mod mosquitto;
pub mod page_status;
pub mod pattern;
pub mod peer;
pub mod schemes;
pub mod secret_forms;
pub mod section;
pub mod stopped;
#[expect(clippy::unwrap_used, reason = "helpers of tests may panic")]
pub mod sweeps;
mod three_probes;

pub use section::workspace_root;
use std::path::{Path, PathBuf};
use std::time::Duration;
pub use three_probes::SILENCE_MS;
use trunnion_cycles::Cycle;
use trunnion_hil_sim::SimSetup;
pub use trunnion_hil_sim::{attempts, pauses};

/// How a cycle mounts its instruments.
pub fn mounted(cycle: &Cycle) -> Vec<SimSetup> {
    cycle.setups.iter().map(SimSetup::from).collect()
}

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

/// A configuration of three probes on ports of this folder; `tables` stand before the devices, `controller` is the table of the
/// controller.
pub fn three_probes(ports: &Path, silence_ms: u32, tables: &str, controller: &str) -> String {
    let devices = three_probes::devices(ports, silence_ms);
    [&three_probes::head("runs"), tables, &three_probes::nest(), &devices, controller].concat()
}
