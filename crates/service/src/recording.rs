//! One cycle from its beginning to a finished recording.

use crate::error::ServiceError;
use crate::live::{Live, Measured, OnProgress, Plan, Start};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tracing::info;
use trunnion_core::{Calibration, Clock, Gap};
use trunnion_record::{RecordSender, Recorder, RecorderHandle, RunHeader};

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

/// For how long a person who waits for the end of a recording waits for room on the disk.
const FINISH_WITHIN: Duration = Duration::from_secs(60);
/// Words of the log line that says how full the queues of a cycle were.
pub const QUEUES: &str = "most messages waiting in the queues";

/// What recording one cycle gave.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// The finished recording.
    pub path: PathBuf,
    /// Further files of the same run: the disk was full in between.
    pub parts: Vec<PathBuf>,
    /// Why the cycle ended, for a person.
    pub ended: String,
    /// Holes in what was asked.
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
    /// What the certificates of the sensors say.
    pub calibrations: &'a [Calibration],
    /// Folder of the recording.
    pub folder: &'a Path,
    /// Name of the run and of the file.
    pub name: &'a str,
}

/// A cycle that is over, whose file is not yet finished.
pub struct Unfinished {
    /// Where the recording will be.
    pub path: PathBuf,
    /// What was measured.
    pub measured: Measured,
    handle: RecorderHandle,
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
    measure_cycle(run, live, start, progress).await?.finish(FINISH_WITHIN).await
}

/// Records one cycle from `start` until it ends; its file is finished while the next cycle is waited for, or none would see
/// that begin.
///
/// # Errors
/// When the plan cannot be measured or the recording cannot be begun.
pub async fn measure_cycle(
    run: &NewRun<'_>,
    live: &mut Live,
    start: Start,
    progress: OnProgress<'_>,
) -> Result<Unfinished, ServiceError> {
    let NewRun { folder, name, .. } = *run;
    let header = header(run, &start, live.clock());
    let (into, named) = (folder.to_owned(), name.to_owned());
    // It syncs the folder, which a slow disk may take long for.
    let recorder = tokio::task::spawn_blocking(move || Recorder::create(&into, &named, &header))
        .await
        .map_err(|_| ServiceError::Broken("recording thread"))??;
    let handle = RecorderHandle::spawn(recorder, RecorderHandle::QUEUE, live.clock().clone())
        .map_err(ServiceError::Thread)?;
    let sender = handle.sender();
    let measured = match live.measure(run.plan, &start, &sender, progress).await {
        Ok(measured) => measured,
        Err(refused) => {
            tokio::task::spawn_blocking(move || handle.finish())
                .await
                .map_err(|_| ServiceError::Broken("recording thread"))??;
            return Err(refused.into());
        }
    };
    info!(run = name, reason = ?measured.reason, points = ?measured.points, "the cycle has ended");
    info!(drivers = measured.most_waiting, recorder = handle.status().most_waiting, "{QUEUES}");
    Ok(Unfinished { path: folder.join(format!("{name}.mcap")), measured, handle })
}

impl Unfinished {
    /// The recorder of the run.
    pub fn recorder(&self) -> RecordSender {
        self.handle.sender()
    }

    /// Finishes the file; a disk that refuses is waited for so long.
    ///
    /// # Errors
    /// When the recording cannot be finished.
    pub async fn finish(self, at_most: Duration) -> Result<Recorded, ServiceError> {
        let Self { path, measured, handle } = self;
        let finished = tokio::task::spawn_blocking(move || handle.finish_within(at_most))
            .await
            .map_err(|_| ServiceError::Broken("recording thread"))??;
        let mut files = finished.files.into_iter().map(|file| file.path);
        Ok(Recorded {
            path: files.next().unwrap_or(path),
            parts: files.collect(),
            ended: format!("{:?}", measured.reason),
            gaps: measured.gaps,
            lost_samples: finished.lost_samples,
        })
    }
}

fn header(run: &NewRun<'_>, start: &Start, clock: &Arc<dyn Clock>) -> RunHeader {
    let NewRun { plan, texts, calibrations, name, .. } = *run;
    RunHeader {
        machine_text: texts.machine.clone(),
        setups: plan.cycle.setups.clone(),
        temperature_channels: start.temperature_channels.clone(),
        probes: plan.channels.iter().map(|channel| channel.name.clone()).collect(),
        probe_roles: plan.channels.iter().map(|channel| channel.role).collect(),
        calibrations: calibrations.to_vec(),
        cycle_text: texts.cycle.clone(),
        config_text: texts.config.clone(),
        software_version: env!("CARGO_PKG_VERSION").into(),
        wall_start_ns: clock.wall_ns() - (clock.now() - start.at).as_nanos() as i64,
        host_start: start.at,
        ..RunHeader::new(name, plan.cycle.run_kind(), &plan.machine.name)
    }
}
