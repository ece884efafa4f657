//! The service loop: wait for a cycle, record it, analyse the recording, report; again.

mod analyses;
mod analyst;
mod disk;
mod health;
mod joining;
mod listening;
mod plants;
mod report;
mod resume;
mod states;
mod status;
mod watchdog;

pub use crate::clock::{day, file_stamp, moment};
pub use crate::error::ServiceError;
pub use crate::recording::{NewRun, QUEUES, Recorded, Texts, Unfinished, measure_cycle, record_cycle};
pub use report::{Report, analyse_recording, in_short, report_at_once, write_report};
pub use states::States;
pub use status::{publish_live, publish_status};

use crate::analysis::{Analyst, JudgedBy};
use crate::board::Board;
use crate::config::{Config, PageConfig};
use crate::cycles::{Choice, Cycles};
use crate::latest::Mounted;
use crate::live::{Live, Measured, Start};
use crate::mqtt;
use crate::page;
use crate::page::{Access, PageAnalyst};
use crate::run_record;
use crate::run_record::Known;
use crate::set_up::SetUp;
use crate::storage::{FolderLock, LockError, Storage};
use analyses::Analyses;
use disk::Disk;
use listening::listening;
use status::notify_systemd;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::task::{JoinHandle, JoinSet};
use tokio_util::sync::CancellationToken;
use tracing::{error, info, warn};
use trunnion::results::{CycleProgress, CycleState, Serves};
use trunnion_core::{Clock, chain};
use trunnion_record::JOURNAL_ENDING;
use trunnion_sync::Progress;

/// For how long the end of a recording waits for room on the disk: a person who works by day finds it. It holds 8 MB of memory.
const FINISH_WITHIN: Duration = Duration::from_secs(24 * 3600);

/// A systemd on this computer takes a message at once, unless its queue is full.
const NOTIFIED_WITHIN: Duration = Duration::from_secs(1);

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
    serve_on(config, cycles, clock, cancel, Board::default(), Analyst::Here).await
}

/// The same with a board that others may read, and choose cycles on, and with this analyst.
///
/// # Errors
/// When a part of the service ends badly.
pub async fn serve_on(
    config: Config,
    cycles: Cycles,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
    board: Board,
    analyst: Analyst,
) -> Result<(), ServiceError> {
    // What cannot be written yet may be a disk that is not mounted: who watches the disk tries again, and says what is wrong.
    let lock = match FolderLock::take(&config.recordings) {
        Ok(lock) => Some(lock),
        Err(held @ LockError::Held { .. }) => return Err(held.into()),
        Err(LockError::Io { .. }) => None,
    };
    let states = States::new(board.clone());
    let page_analyst = PageAnalyst::new(analyst.clone(), config.analysis, clock.clone());
    let runs = page::Runs::of_folder(&config.recordings, None, page_analyst).judged_by(cycles.clone());
    let analyses = Analyses {
        runs: Arc::new(runs),
        analyst,
        limits: config.analysis,
        board: board.clone(),
        states: states.clone(),
        clock: clock.clone(),
        cancel: cancel.clone(),
        one: Arc::new(Semaphore::new(1)),
    };
    let known = Known::read(&config.recordings);
    analyses.publish_last(&known);
    let names: Vec<&str> = cycles.names().collect();
    board.operator().offer(cycles.names());
    states.begin(
        CycleState::Ready,
        "",
        CycleProgress {
            cycles: Some(cycles.names().map(str::to_owned).collect()),
            waits_for: Some(config.cycle_start.about().to_string()),
            ..CycleProgress::default()
        },
    );
    let broker = config.mqtt.clone().map(|mqtt| tokio::spawn(mqtt::run(mqtt, board.clone(), cancel.clone())));
    let bounds = config.cycle_bounds();
    let live = Live::start(config.devices.clone(), bounds, clock.clone(), cancel.clone());
    let set_up = SetUp::new(&board, cycles.first().map(|choice| &choice.plan));
    let set_up = set_up.writing(config.file.clone(), clock.clone(), live.latest().clone());
    // No step is under way: a broker may hold one of a service that was lost.
    set_up.stop();
    let mut live = live.led_by(board.operator()).setting_up(&set_up);
    if let Some(first) = cycles.first() {
        live.latest().set_mounted(Mounted::of(&first.plan));
    }
    let devices: Vec<String> = config.devices.iter().map(|device| device.name.clone()).collect();
    let status = publish_status(devices, live.states(), board.clone(), states.clone(), cancel.clone());
    let status = tokio::spawn(status);
    let latest = live.latest().clone();
    let shown = tokio::spawn(publish_live(latest, cycles.needed(), board.clone(), cancel.clone()));
    let storage = Storage::new(&config.recordings, config.storage, config.analysis.tries);
    let disk = Disk::new(storage, lock, live.latest().clone(), board.clone(), clock.clone());
    let watched = tokio::spawn(disk.clone().watch(cancel.clone()));
    let pinged =
        tokio::spawn(watchdog::watch(live.latest().clone(), board.clone(), clock.clone(), cancel.clone()));
    let page = match &config.page {
        Some(place) => page(place, &set_up, &config, &cycles, &analyses),
        None => None,
    };
    let adapter = plants::adapter(&config, &board, &cancel);
    let opcua = plants::opcua_server(&config, &board, &cancel);
    notify_systemd(sd_notify::NotifyState::Ready);
    // Cycles are analysed while the next one is waited for and measured.
    let mut reports = JoinSet::new();
    let of_before = analyses.clone();
    reports.spawn(async move { of_before.publish_alarms().await });
    let usual = cycles.first().map(Choice::judged_by).unwrap_or_default();
    // What a kill left behind is recovered before a cycle of this start is analysed, which may go on with it.
    let turn = analyses.one.clone().acquire_owned().await.ok();
    reports.spawn(analyses.clone().resume(config.recordings.clone(), known, cycles.clone(), usual, turn));
    info!(machine = config.name, cycles = names.join(", "), "waiting for {}", config.cycle_start.about());
    while let Some(start) = live.wait_for_start().await {
        let chosen = board.operator().take_chosen();
        let found = cycles.find(&start.program, start.signal, chosen.as_deref());
        let found = match found.map_err(|refused| refused.to_string()) {
            Ok(choice) => disk.make_room(choice).await.map(|()| choice),
            Err(refused) => Err(refused),
        };
        match found {
            Ok(choice) => {
                let choice = &choice.with_nest(set_up.written());
                let unfinished = measure(&config, choice, &mut live, start, &states, clock.as_ref()).await;
                if let Some((name, unfinished)) = unfinished {
                    let (cycle, judged_by) = (choice.plan.cycle.name.clone(), choice.judged_by());
                    reports.spawn(finish_and_report(name, unfinished, cycle, judged_by, analyses.clone()));
                }
            }
            Err(why) => {
                warn!(program = start.program, "not measured: {why}");
                states.begin(
                    CycleState::Refused,
                    "",
                    CycleProgress {
                        program: Some(start.program),
                        why: Some(why),
                        ..CycleProgress::default()
                    },
                );
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
    let stopping = notify_systemd(sd_notify::NotifyState::Stopping);
    if tokio::time::timeout(NOTIFIED_WITHIN, stopping).await.is_err() {
        warn!("systemd does not take that the service stops");
    }
    let (shown, watched) = (Some(shown), Some(watched));
    for (task, what) in [
        (Some(status), "status"),
        (watched, "disk"),
        (Some(pinged), "watchdog"),
        (shown, "live values"),
        (page, "page"),
        (adapter, "MTConnect adapter"),
        (opcua, "OPC UA server"),
        (broker, "MQTT connection"),
    ] {
        if let Some(task) = task {
            task.await.map_err(|_| ServiceError::Broken(what))?;
        }
    }
    Ok(())
}

/// What the topic `cycle` says while one is measured.
pub fn cycle_under_way(now: Progress) -> CycleProgress {
    CycleProgress {
        done: Some(now.done),
        total: Some(now.total),
        seconds_left: now.seconds_left,
        ..CycleProgress::default()
    }
}

/// Starts the page; measuring goes on without it where its certificate cannot be read.
fn page(
    place: &PageConfig,
    set_up: &SetUp,
    config: &Config,
    cycles: &Cycles,
    Analyses { board, clock, cancel, runs, .. }: &Analyses,
) -> Option<JoinHandle<()>> {
    let access = match place.lan.as_ref().map_or_else(|| Ok(Access::this_computer()), Access::of_lan) {
        Ok(access) => access,
        Err(failure) => {
            warn!("there is no page: {}", chain(&failure));
            board.set_connection("page", &chain(&failure));
            return None;
        }
    };
    let shared = page::Shared {
        serves: Serves::Service,
        name: config.name.clone(),
        runs: runs.clone(),
        board: board.clone(),
        cycles: cycles.all().map(Choice::shown).collect(),
        clock: clock.clone(),
        set_up: Some(set_up.clone()),
    };
    let (address, board, cancel) = (place.listen, board.clone(), cancel.clone());
    Some(tokio::spawn(async move {
        let Some(listener) = listening("page", address, &board, &cancel).await else { return };
        // The system chooses the port where the configuration leaves it open.
        let address = listener.local_addr().unwrap_or(address);
        info!("the page is at {}://{address}", access.scheme());
        if let Err(error) = page::serve(listener, Arc::new(shared), access, cancel).await {
            warn!(%error, "the page ended");
            board.set_connection("page", &format!("it ended: {error}"));
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
    let name = run_name(&config.recordings, cycle, clock.wall_ns());
    let about = CycleProgress {
        cycle: Some(cycle.clone()),
        program: Some(start.program.clone()),
        why: Some(start.why.clone()),
        ..CycleProgress::default()
    };
    states.begin(CycleState::Measuring, &name, about);
    live.latest().set_mounted(Mounted::of(&choice.plan));
    let mut progress = |now: Progress| {
        states.go_on(CycleState::Measuring, &name, cycle_under_way(now));
    };
    let (calibrations, folder) = (&config.calibrations[..], &config.recordings);
    let run = NewRun { plan: &choice.plan, texts: &choice.texts, calibrations, folder, name: &name };
    match measure_cycle(&run, live, start, &mut progress).await {
        Ok(unfinished) => {
            let Measured { points, reason, gaps, .. } = &unfinished.measured;
            let measured = CycleProgress {
                recording: run_record::file_name(&unfinished.path),
                ended: Some(format!("{reason:?}")),
                read: Some(points.read),
                unsettled: Some(points.unsettled),
                missing: Some(points.missing),
                gaps: Some(gaps.len()),
                ..CycleProgress::default()
            };
            states.go_on(CycleState::Analysing, &name, measured);
            Some((name, unfinished))
        }
        Err(failure) => {
            error!(error = &failure as &dyn std::error::Error, run = name, "the cycle failed");
            states.go_on(
                CycleState::Failed,
                &name,
                CycleProgress { why: Some(chain(&failure)), ..CycleProgress::default() },
            );
            None
        }
    }
}

async fn finish_and_report(
    name: String,
    unfinished: Unfinished,
    cycle: String,
    judged_by: JudgedBy,
    analyses: Analyses,
) {
    let (recorder, cancel) = (unfinished.recorder(), analyses.cancel.clone());
    let giving_up = tokio::spawn(async move {
        cancel.cancelled().await;
        recorder.give_up();
    });
    let finished = unfinished.finish(FINISH_WITHIN).await;
    giving_up.abort();
    match finished {
        Ok(recorded) => {
            let record = run_record::of_recorded(&recorded, &cycle, moment(analyses.clock.wall_ns()));
            analyses.keep(&recorded.path, &record);
            analyses.report(recorded.path, record, judged_by).await;
        }
        Err(failure) => {
            error!(run = name, "the recording cannot be finished: {}", chain(&failure));
            analyses.report_failure(&name, &chain(&failure));
        }
    }
}

/// The name of a new run of a cycle that begins now.
pub fn run_name(folder: &Path, cycle: &str, wall_ns: i64) -> String {
    free_name(folder, &format!("{cycle}-{}", file_stamp(wall_ns)))
}

/// A name that no recording has: two cycles may begin within a second, and nothing is overwritten.
pub fn free_name(folder: &Path, name: &str) -> String {
    let is_free = |name: &String| {
        ["", JOURNAL_ENDING].iter().all(|ending| !folder.join(format!("{name}.mcap{ending}")).exists())
    };
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(is_free).unwrap_or_else(|| name.to_owned())
}
