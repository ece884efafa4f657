//! The service loop: wait for a cycle, record it, analyse the recording, report; again.

mod report;
mod status;

pub use report::analyse_recording;

use crate::config::Config;
use crate::live::{Plan, PlanError};
use crate::mqtt::Board;
use crate::{live, mqtt};
use report::report_cycle;
use serde_json::json;
use status::{publish_status, tell_systemd};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use tracing::{error, info, warn};
use trunnion::analysis::AnalysisError;
use trunnion_core::reading::Message;
use trunnion_core::{Clock, Gap};
use trunnion_effects::Model;
use trunnion_engine::ExperimentError;
use trunnion_protocol::mtconnect::format_timestamp;
use trunnion_record::{RecordError, Recorder, RecorderHandle, RunHeader};
use trunnion_sync::{CycleBounds, Progress, TimeBase};

/// Why the service, or one cycle of it, failed.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// An answer that JSON cannot hold.
    #[error("cannot write an answer as JSON")]
    Json(#[from] serde_json::Error),
    /// The cycle cannot be measured with these devices.
    #[error("the cycle cannot be measured")]
    Plan(#[from] PlanError),
    /// The recording failed.
    #[error("recording failed")]
    Record(#[from] RecordError),
    /// The writing thread could not be started.
    #[error("cannot start the recording thread")]
    Thread(#[source] std::io::Error),
    /// A result could not be written.
    #[error("cannot write {path}")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// The points do not make an experiment.
    #[error("the recording {path} cannot be analysed")]
    Experiment {
        /// The recording.
        path: PathBuf,
        /// Why.
        source: ExperimentError,
    },
    /// The analysis failed.
    #[error("analysing {path} failed")]
    Analysis {
        /// The recording.
        path: PathBuf,
        /// Why.
        source: Box<AnalysisError>,
    },
    /// A part of the service panicked.
    #[error("the {0} ended badly; this is a defect of the program")]
    Broken(&'static str),
}

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

/// Runs until `cancel`. Cycles that fail are reported and do not end the service.
///
/// # Errors
/// When the configuration cannot measure the cycle.
pub async fn serve(
    config: Config,
    plan: Plan,
    texts: Texts,
    model: Model,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
) -> Result<(), ServiceError> {
    live::check(&plan)?;
    recover(&config.recordings);
    let board = Board::default();
    let broker = config.mqtt.clone().map(|mqtt| tokio::spawn(mqtt::run(mqtt, board.clone(), cancel.clone())));
    let mut acquisition = trunnion_acquire::start(
        config.devices.clone(),
        clock.clone(),
        cancel.clone(),
        trunnion_acquire::supervisor::QUEUE_LENGTH,
    );
    let names: Vec<String> = config.devices.iter().map(|device| device.name.clone()).collect();
    let status =
        tokio::spawn(publish_status(names, acquisition.states.clone(), board.clone(), cancel.clone()));
    let mut timebase = TimeBase::new(clock.now());
    tell_systemd(&[sd_notify::NotifyState::Ready]);
    let mut bounds = CycleBounds::new(config.cycle_start.clone());
    // Cycles are analysed while the next one is waited for and measured.
    let mut reports = JoinSet::new();
    info!(machine = config.name, cycle = plan.cycle.name, "waiting for {}", config.cycle_start.about());
    while let Some(start) =
        live::wait_for_start(&mut acquisition.messages, &mut timebase, &mut bounds, &cancel).await
    {
        let name = format!("{}-{}", plan.cycle.name, file_stamp(clock.wall_ns()));
        board.set("cycle", &json!({ "state": "measuring", "run": name }));
        let mut progress = |now: Progress| {
            board.set(
                "cycle",
                &json!({ "state": "measuring", "run": name, "done": now.done, "total": now.total,
                "seconds_left": now.seconds_left }),
            );
        };
        let recorded = record_cycle(
            &plan,
            &texts,
            &config.recordings,
            &name,
            start,
            &mut acquisition.messages,
            &mut timebase,
            &mut bounds,
            &clock,
            &cancel,
            &mut progress,
        )
        .await;
        match recorded {
            Ok(recorded) => {
                board.set(
                    "cycle",
                    &json!({ "state": "done", "run": recorded.path.display().to_string(),
                    "ended": recorded.ended, "gaps": recorded.gaps.len(),
                    "lost_samples": recorded.lost_samples }),
                );
                let (model, machine, board) = (model.clone(), plan.machine.clone(), board.clone());
                let date = day(clock.wall_ns());
                reports.spawn(async move {
                    if let Err(failure) = report_cycle(recorded, model, machine, date, &board).await {
                        error!(error = &failure as &dyn std::error::Error, run = name, "the analysis failed");
                        board.set(
                            "result",
                            &json!({ "state": "failed", "run": name, "why": chain(&failure) }),
                        );
                    }
                });
            }
            Err(failure) => {
                error!(error = &failure as &dyn std::error::Error, run = name, "the cycle failed");
                board.set("cycle", &json!({ "state": "failed", "run": name, "why": chain(&failure) }));
            }
        }
        while let Some(ended) = reports.try_join_next() {
            ended.map_err(|_| ServiceError::Broken("report"))?;
        }
    }
    while let Some(ended) = reports.join_next().await {
        ended.map_err(|_| ServiceError::Broken("report"))?;
    }
    acquisition.stop().await;
    tell_systemd(&[sd_notify::NotifyState::Stopping]);
    for (task, what) in [(Some(status), "status"), (broker, "MQTT connection")] {
        if let Some(task) = task {
            task.await.map_err(|_| ServiceError::Broken(what))?;
        }
    }
    Ok(())
}

/// Records one cycle from `start` until it ends and finishes its file.
///
/// # Errors
/// When the plan cannot be measured or the recording cannot be finished.
#[expect(clippy::too_many_arguments, reason = "the parts of a running service, borrowed separately")]
pub async fn record_cycle(
    plan: &Plan,
    texts: &Texts,
    folder: &Path,
    name: &str,
    start: live::Start,
    messages: &mut mpsc::Receiver<Message>,
    timebase: &mut TimeBase,
    bounds: &mut CycleBounds,
    clock: &Arc<dyn Clock>,
    cancel: &CancellationToken,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Recorded, ServiceError> {
    let header = header(plan, texts, name, &start, clock);
    let recorder = Recorder::create(folder, name, &header)?;
    let handle =
        RecorderHandle::spawn(recorder, RECORDER_QUEUE, clock.clone()).map_err(ServiceError::Thread)?;
    let sender = handle.sender();
    let measured =
        live::measure(plan, &start, messages, timebase, bounds, &sender, clock, cancel, progress).await;
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

fn header(plan: &Plan, texts: &Texts, name: &str, start: &live::Start, clock: &Arc<dyn Clock>) -> RunHeader {
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

/// Finishes recordings that a kill left behind. What cannot be recovered stays where it is and is told.
fn recover(folder: &Path) {
    match trunnion_record::recover_orphans(folder) {
        Ok(files) => {
            for recovered in files {
                match recovered {
                    Ok(file) => {
                        warn!(file = %file.path.display(), "recovered a recording that was not finished")
                    }
                    Err(failure) => {
                        warn!(error = &failure as &dyn std::error::Error, "cannot recover a recording")
                    }
                }
            }
        }
        Err(failure) => {
            warn!(error = &failure as &dyn std::error::Error, "cannot look for unfinished recordings")
        }
    }
}

/// Every cause of an error in one line.
fn chain(failure: &dyn std::error::Error) -> String {
    let mut text = failure.to_string();
    let mut cause = failure.source();
    while let Some(next) = cause {
        text.push_str(": ");
        text.push_str(&next.to_string());
        cause = next.source();
    }
    text
}

/// `YYYYMMDDThhmmssZ`.
pub fn file_stamp(wall_ns: i64) -> String {
    let stamp: String =
        format_timestamp(wall_ns).chars().filter(char::is_ascii_alphanumeric).take(15).collect();
    stamp + "Z"
}

/// `YYYY-MM-DD`.
pub fn day(wall_ns: i64) -> String {
    format_timestamp(wall_ns).chars().take(10).collect()
}
