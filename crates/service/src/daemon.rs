//! The service loop: wait for a cycle, record it, analyse the recording, report; again.

mod report;
mod states;
mod status;

pub use crate::clock::{day, file_stamp};
pub use crate::error::ServiceError;
pub use crate::recording::{NewRun, QUEUES, Recorded, Texts, Unfinished, measure_cycle, record_cycle};
pub use report::{analyse_recording, write_report};
pub use states::{CycleState, States};
pub use status::publish_status;

use crate::config::Config;
use crate::cycles::{Choice, Cycles};
use crate::error::chain;
use crate::latest::Mounted;
use crate::live::{Live, Measured, Start};
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
use trunnion_sync::{CycleBounds, Progress};

/// Runs until `cancel`. Cycles that fail are reported and do not end the service.
///
/// # Errors
/// When a part of the service ends badly.
pub async fn serve(
    config: Config,
    cycles: Cycles,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
) -> Result<(), ServiceError> {
    let board = Board::default();
    serve_on(config, cycles, clock, cancel, board).await
}

/// The same with a board that others may read, and choose cycles on.
///
/// # Errors
/// When a part of the service ends badly.
pub async fn serve_on(
    config: Config,
    cycles: Cycles,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
    board: Board,
) -> Result<(), ServiceError> {
    recover(&config.recordings);
    let states = States::new(board.clone());
    let names: Vec<&str> = cycles.names().collect();
    states.begin(CycleState::Ready, "", json!({ "cycles": names, "waits_for": config.cycle_start.about() }));
    let broker = config.mqtt.clone().map(|mqtt| tokio::spawn(mqtt::run(mqtt, board.clone(), cancel.clone())));
    let bounds = CycleBounds::new(config.cycle_start.clone());
    let mut live = Live::start(config.devices.clone(), bounds, clock.clone(), cancel.clone());
    if let Some(first) = cycles.first() {
        live.latest().set_mounted(Mounted::of(&first.plan));
    }
    let devices: Vec<String> = config.devices.iter().map(|device| device.name.clone()).collect();
    let status = publish_status(devices, live.states(), board.clone(), states.clone(), cancel.clone());
    let status = tokio::spawn(status);
    let latest = live.latest().clone();
    let shown = tokio::spawn(publish_live(latest, cycles.needed(), board.clone(), cancel.clone()));
    let page = match config.page {
        Some(address) => page(address, &config, &cycles, &board, &clock, &cancel).await,
        None => None,
    };
    report_systemd(&[sd_notify::NotifyState::Ready]);
    // Cycles are analysed while the next one is waited for and measured.
    let mut reports = JoinSet::new();
    info!(machine = config.name, cycles = names.join(", "), "waiting for {}", config.cycle_start.about());
    while let Some(start) = live.wait_for_start().await {
        match cycles.find(&start.program, board.take_chosen().as_deref()) {
            Ok(choice) => {
                let unfinished = measure(&config, choice, &mut live, start, &states, clock.as_ref()).await;
                if let Some((name, unfinished)) = unfinished {
                    let (model, board, states) = (choice.model.clone(), board.clone(), states.clone());
                    let date = day(clock.wall_ns());
                    reports.spawn(finish_and_report(name, unfinished, model, date, board, states));
                }
            }
            Err(refused) => {
                warn!(program = start.program, "not measured: {refused}");
                let why = refused.to_string();
                states.begin(CycleState::Refused, "", json!({ "program": start.program, "why": why }));
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
pub fn cycle_under_way(now: Progress) -> serde_json::Value {
    json!({ "done": now.done, "total": now.total, "seconds_left": now.seconds_left })
}

/// Starts the page; measuring goes on without it where it cannot listen.
async fn page(
    address: SocketAddr,
    config: &Config,
    cycles: &Cycles,
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
        cycle: cycles.first().and_then(|choice| page::grid_of(&choice.plan.machine, &choice.plan.cycle)),
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

/// Measures one cycle and reports how it goes; the name of the run and what was measured, `None` when that failed.
async fn measure(
    config: &Config,
    choice: &Choice,
    live: &mut Live,
    start: Start,
    states: &States,
    clock: &dyn Clock,
) -> Option<(String, Unfinished)> {
    let cycle = &choice.plan.cycle.name;
    let name = free_name(&config.recordings, cycle, clock.wall_ns());
    let about = json!({ "cycle": cycle, "program": start.program, "why": start.why });
    states.begin(CycleState::Measuring, &name, about);
    live.latest().set_mounted(Mounted::of(&choice.plan));
    let mut progress = |now: Progress| {
        states.go_on(CycleState::Measuring, &name, cycle_under_way(now));
    };
    let run = NewRun { plan: &choice.plan, texts: &choice.texts, folder: &config.recordings, name: &name };
    match measure_cycle(&run, live, start, &mut progress).await {
        Ok(unfinished) => {
            let Measured { points, reason, gaps, .. } = &unfinished.measured;
            let measured = json!({ "recording": unfinished.path.display().to_string(),
                "ended": format!("{reason:?}"), "read": points.read, "unsettled": points.unsettled,
                "missing": points.missing, "gaps": gaps.len() });
            states.go_on(CycleState::Analysing, &name, measured);
            Some((name, unfinished))
        }
        Err(failure) => {
            error!(error = &failure as &dyn std::error::Error, run = name, "the cycle failed");
            states.go_on(CycleState::Failed, &name, json!({ "why": chain(&failure) }));
            None
        }
    }
}

async fn finish_and_report(
    name: String,
    unfinished: Unfinished,
    model: Model,
    date: String,
    board: Board,
    states: States,
) {
    let reported = async { report_cycle(unfinished.finish().await?, model, date, &board).await };
    match reported.await {
        Ok(()) => states.go_on(CycleState::Done, &name, json!({})),
        Err(failure) => {
            error!(error = &failure as &dyn std::error::Error, run = name, "the analysis failed");
            let why = chain(&failure);
            board.set("result", &json!({ "state": CycleState::Failed.as_str(), "run": name, "why": why }));
            states.go_on(CycleState::Failed, &name, json!({ "why": why }));
        }
    }
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
                match recovered.finished {
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
