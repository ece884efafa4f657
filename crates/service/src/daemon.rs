//! The service loop: wait for a cycle, record it, analyse the recording, report; again.

mod report;
mod status;

pub use crate::error::ServiceError;
pub use crate::recording::{NewRun, QUEUES, Recorded, Texts, Unfinished, measure_cycle, record_cycle};
pub use report::{analyse_recording, write_report};
pub use status::publish_status;

use crate::config::Config;
use crate::error::chain;
use crate::latest::Mounted;
use crate::live::{Live, Measured, Plan, check};
use crate::mqtt;
use crate::mqtt::Board;
use crate::page;
use report::report_cycle;
use serde_json::json;
use status::{publish_live, report_systemd};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use tokio::task::{JoinHandle, JoinSet};
use tokio_util::sync::CancellationToken;
use tracing::{error, info, warn};
use trunnion::Model;
use trunnion::results::Serves;
use trunnion_core::Clock;
use trunnion_protocol::mtconnect::timestamp;
use trunnion_sync::{CycleBounds, Progress};

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
    let needed = check(&plan)?;
    recover(&config.recordings);
    let board = Board::default();
    let broker = config.mqtt.clone().map(|mqtt| tokio::spawn(mqtt::run(mqtt, board.clone(), cancel.clone())));
    let bounds = CycleBounds::new(config.cycle_start.clone()).with_first_pose(plan.first_pose());
    let mut live = Live::start(config.devices.clone(), bounds, clock.clone(), cancel.clone());
    let names: Vec<String> = config.devices.iter().map(|device| device.name.clone()).collect();
    let status = tokio::spawn(publish_status(names, live.states(), board.clone(), cancel.clone()));
    live.latest().set_mounted(Mounted::of(&plan));
    let latest = live.latest().clone();
    let shown = tokio::spawn(publish_live(latest, needed, board.clone(), cancel.clone()));
    let page = match config.page {
        Some(address) => page(address, &config, &plan, &board, &clock, &cancel).await,
        None => None,
    };
    report_systemd(&[sd_notify::NotifyState::Ready]);
    // Cycles are analysed while the next one is waited for and measured.
    let mut reports = JoinSet::new();
    info!(machine = config.name, cycle = plan.cycle.name, "waiting for {}", config.cycle_start.about());
    while let Some(start) = live.wait_for_start().await {
        let name = free_name(&config.recordings, &plan.cycle.name, clock.wall_ns());
        board.set("cycle", &json!({ "state": "measuring", "run": name, "why": start.why }));
        let mut progress = |now: Progress| {
            board.set("cycle", &cycle_under_way(&name, now));
        };
        let run = NewRun { plan: &plan, texts: &texts, folder: &config.recordings, name: &name };
        match measure_cycle(&run, &mut live, start, &mut progress).await {
            Ok(unfinished) => {
                let Measured { points, reason, gaps, .. } = &unfinished.measured;
                board.set(
                    "cycle",
                    &json!({ "state": "done", "run": unfinished.path.display().to_string(),
                    "ended": format!("{reason:?}"), "read": points.read, "unsettled": points.unsettled,
                    "missing": points.missing, "gaps": gaps.len() }),
                );
                let (model, board) = (model.clone(), board.clone());
                let date = day(clock.wall_ns());
                reports.spawn(async move {
                    if let Err(failure) = finish_and_report(unfinished, model, date, &board).await {
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
    live.stop().await;
    report_systemd(&[sd_notify::NotifyState::Stopping]);
    let shown = Some(shown);
    for (task, what) in
        [(Some(status), "status"), (shown, "live values"), (page, "page"), (broker, "MQTT connection")]
    {
        if let Some(task) = task {
            task.await.map_err(|_| ServiceError::Broken(what))?;
        }
    }
    Ok(())
}

/// What the topic `cycle` says while one is measured.
pub fn cycle_under_way(run: &str, now: Progress) -> serde_json::Value {
    json!({ "state": "measuring", "run": run, "done": now.done, "total": now.total, "seconds_left": now.seconds_left })
}

/// Starts the page; measuring goes on without it where it cannot listen.
async fn page(
    address: SocketAddr,
    config: &Config,
    plan: &Plan,
    board: &Board,
    clock: &Arc<dyn Clock>,
    cancel: &CancellationToken,
) -> Option<JoinHandle<()>> {
    let listener = match tokio::net::TcpListener::bind(address).await {
        Ok(listener) => listener,
        Err(error) => {
            warn!(%error, %address, "there is no page: the address cannot be listened on");
            return None;
        }
    };
    let shared = page::Shared {
        serves: Serves::Service,
        name: config.name.clone(),
        runs: Arc::new(page::Runs::of_folder(&config.recordings, config.model.clone())),
        board: board.clone(),
        cycle: page::grid_of(&plan.machine, &plan.cycle),
        clock: clock.clone(),
    };
    info!("the page is at http://{address}");
    let cancel = cancel.clone();
    Some(tokio::spawn(async move {
        if let Err(error) = page::serve(listener, Arc::new(shared), cancel).await {
            warn!(%error, "the page ended");
        }
    }))
}

async fn finish_and_report(
    unfinished: Unfinished,
    model: Model,
    date: String,
    board: &Board,
) -> Result<(), ServiceError> {
    report_cycle(unfinished.finish().await?, model, date, board).await
}

/// The name of a new run: two cycles may begin within a second.
pub fn free_name(folder: &Path, cycle: &str, wall_ns: i64) -> String {
    let name = format!("{cycle}-{}", file_stamp(wall_ns));
    let is_free = |name: &String| {
        ["mcap", "mcap.active"].iter().all(|ending| !folder.join(format!("{name}.{ending}")).exists())
    };
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.clone()).chain(numbered).find(is_free).unwrap_or(name)
}

/// Finishes recordings that a kill left behind. What cannot be recovered stays where it is and is reported.
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

/// `YYYYMMDDThhmmssZ`.
pub fn file_stamp(wall_ns: i64) -> String {
    timestamp(wall_ns).strftime("%Y%m%dT%H%M%SZ").to_string()
}

/// `YYYY-MM-DD`.
pub fn day(wall_ns: i64) -> String {
    timestamp(wall_ns).strftime("%Y-%m-%d").to_string()
}
