//! One cycle from its beginning to a finished recording.

use crate::error::ServiceError;
use crate::live::{Live, OnProgress, Plan, Start};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing::info;
use trunnion_core::{Clock, Gap};
use trunnion_record::{Recorder, RecorderHandle, RunHeader};

/// Texts that go into a recording word for word.
#[derive(Clone, Debug)]
pub struct Texts {
    /// The machine file.
    pub machine: String,
    /// The cycle file.
    pub cycle: String,
    /// The configuration.
    pub config: String,
}

/// Items between the service and the writing thread: a second of three probes at 4 kHz, with room.
const RECORDER_QUEUE: usize = 32_768;
/// Words of the log line that says how full the queues of a cycle were.
pub const QUEUES: &str = "most messages waiting in the queues";

/// What recording one cycle gave.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The finished recording.
    pub path: PathBuf,
    /// Why the cycle ended, for a person.
    pub ended: String,
    /// Holes in the data.
    pub gaps: Vec<Gap>,
    /// Samples that the recorder lost.
    pub lost_samples: u64,
}

/// A cycle to be measured, and where its recording goes.
#[derive(Clone, Copy, Debug)]
pub struct NewRun<'a> {
    /// Machine, cycle, nest, channels.
    pub plan: &'a Plan,
    /// What is kept word for word.
    pub texts: &'a Texts,
    /// Folder of the recording.
    pub folder: &'a Path,
    /// Name of the run and of the file.
    pub name: &'a str,
}

/// Records one cycle from `start` until it ends and finishes its file.
///
/// # Errors
/// When the plan cannot be measured or the recording cannot be finished.
pub async fn record_cycle(
    run: &NewRun<'_>,
    live: &mut Live,
    start: Start,
    progress: OnProgress<'_>,
) -> Result<Recorded, ServiceError> {
    let NewRun { folder, name, .. } = *run;
    let recorder = Recorder::create(folder, name, &header(run, &start, live.clock()))?;
    let handle = RecorderHandle::spawn(recorder, RECORDER_QUEUE, live.clock().clone())
        .map_err(ServiceError::Thread)?;
    let sender = handle.sender();
    let measured = live.measure(run.plan, &start, &sender, progress).await;
    drop(sender);
    let recorder_waiting = handle.status().most_waiting;
    let finished = tokio::task::spawn_blocking(move || handle.finish())
        .await
        .map_err(|_| ServiceError::Broken("recording thread"))??;
    let measured = measured?;
    info!(run = name, reason = ?measured.reason, points = measured.points, "the cycle has ended");
    info!(drivers = measured.most_waiting, recorder = recorder_waiting, "{QUEUES}");
    let path =
        finished.files.first().map_or_else(|| folder.join(format!("{name}.mcap")), |file| file.path.clone());
    Ok(Recorded {
        path,
        ended: format!("{:?}", measured.reason),
        gaps: measured.gaps,
        lost_samples: finished.lost_samples,
    })
}

fn header(run: &NewRun<'_>, start: &Start, clock: &Arc<dyn Clock>) -> RunHeader {
    let NewRun { plan, texts, name, .. } = *run;
    RunHeader {
        name: name.into(),
        kind: plan.cycle.run_kind(),
        machine_name: plan.machine.name.clone(),
        machine_text: texts.machine.clone(),
        setups: plan.cycle.setups.clone(),
        temperature_channels: start.temperature_channels.clone(),
        probes: plan.channels.iter().map(|channel| channel.name.clone()).collect(),
        probe_roles: plan.channels.iter().map(|channel| channel.role).collect(),
        cycle_text: texts.cycle.clone(),
        config_text: texts.config.clone(),
        software_version: env!("CARGO_PKG_VERSION").into(),
        wall_start_ns: clock.wall_ns() - (clock.now() - start.at).as_nanos() as i64,
        host_start: start.at,
    }
}
