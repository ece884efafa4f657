//! `trunnion record`: one cycle, recorded, analysed and reported; then the program ends.

use super::daemon::prepare_cycle;
use super::progress_bar::ProgressBar;
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::Context;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use trunnion::results::Verdict;
use trunnion_core::Clock;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Choice;
use trunnion_service::daemon::{self, NewRun, Recorded, Report};
use trunnion_service::latest::{Latest, Mounted, Readiness};
use trunnion_service::live::{Live, check};
use trunnion_service::slow_probes::too_slow;
use trunnion_service::storage::FolderLock;

/// Record one cycle, analyse it, and end
///
/// Waits for the cycle as the service does, by `[cycle_start]` of the configuration. Control-C ends the cycle early; what was read is kept.
/// Exit code 3 when no verdict is given: too little of the cycle was read, or it is not plausible.
///
/// Example: trunnion record config/cycles/r-test-static.toml --config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    /// Cycle file, in place of that of the configuration
    #[arg(value_name = "CYCLE")]
    cycle: PathBuf,
    /// Configuration: devices, nest, folder of the recordings
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let (config, choice) = prepare_cycle(&args.config, &args.cycle)?;
    let _folder = FolderLock::take(&config.recordings)?;
    let clock: Arc<dyn Clock> = Arc::new(SystemClock::start());
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let recorded = runtime.block_on(record(&config, &choice, clock.clone()))?;
    let cycle = &choice.plan.cycle.name;
    let Report { analysed, compared, .. } =
        daemon::report_at_once(&recorded, cycle, &choice.model, clock.wall_ns())?;
    terminal::print(&compared.summary())?;
    terminal::print(&format!("{}\n", recorded.path.with_extension("html").display()))?;
    Ok(match analysed.first().results().verdict {
        Verdict::NotJudged => Outcome::Withheld,
        _ if recorded.lost_samples > 0 || !recorded.gaps.is_empty() => Outcome::DataLoss,
        _ => Outcome::Done,
    })
}

async fn record(config: &Config, choice: &Choice, clock: Arc<dyn Clock>) -> anyhow::Result<Recorded> {
    let Choice { plan, texts, .. } = choice;
    let needed = check(plan)?;
    let cancel = CancellationToken::new();
    let stop = cancel.clone();
    tokio::spawn(async move {
        // Without the signal the cycle ends by itself.
        if tokio::signal::ctrl_c().await.is_ok() {
            stop.cancel();
        }
    });
    let bounds = config.cycle_bounds();
    let name = daemon::run_name(&config.recordings, &plan.cycle.name, clock.wall_ns());
    let mut live = Live::start(config.devices.clone(), bounds, clock, cancel);
    live.latest().set_mounted(Mounted::of(plan));
    if let Some(slow) = too_slow(&config.devices, plan) {
        terminal::remark(&slow);
    }
    terminal::remark(&format!("waiting for {}", config.cycle_start.about()));
    let ready = tokio::spawn(say_readiness(live.latest().clone(), needed));
    let start = live.wait_for_start().await.context("stopped before the cycle began");
    ready.abort();
    let start = start?;
    let run =
        NewRun { plan, texts, calibrations: &config.calibrations, folder: &config.recordings, name: &name };
    let mut bar = ProgressBar::new(false);
    let recorded = daemon::record_cycle(&run, &mut live, start, &mut |progress| bar.show(progress)).await;
    bar.clear();
    live.stop().await;
    Ok(recorded?)
}

/// Says on standard error what stands against the cycle, before its first pose.
async fn say_readiness(latest: Latest, needed: Vec<u16>) {
    let mut readiness = Readiness::default();
    let mut second = tokio::time::interval(Duration::from_secs(1));
    loop {
        second.tick().await;
        match readiness.changed(latest.before_a_cycle(&needed)) {
            None => {}
            Some([]) => terminal::remark("every channel reads and is at its centre"),
            Some(why) => why.iter().for_each(|why| terminal::remark(&format!("not ready: {why}"))),
        }
    }
}
