//! `trunnion daemon`: the service.

use crate::load;
use crate::outcome::Outcome;
use anyhow::Context;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::prelude::*;
use trunnion::Model;
use trunnion::cycles::Cycle;
use trunnion_acquire::config::channels;
use trunnion_service::analysis::Analyst;
use trunnion_service::bar_zero;
use trunnion_service::begun_by::BegunBy;
use trunnion_service::board::Board;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::{Config, ProgramCycle};
use trunnion_service::cycles::{Choice, Cycles};
use trunnion_service::daemon;
use trunnion_service::daemon::Texts;
use trunnion_service::live::Plan;
use trunnion_service::private_files;

/// Run as a service: wait for a cycle, record it, analyse it, report
///
/// Example: trunnion daemon --config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    /// Configuration file
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
}

/// A configuration with everything it names.
pub struct Prepared {
    pub config: Config,
    pub cycles: Cycles,
}

/// Reads a configuration and the files it names.
pub fn prepare(path: &Path) -> anyhow::Result<Prepared> {
    with_files(Config::parse(path, &load::read(path)?)?)
}

/// The same of a configuration that was read.
pub fn with_files(config: Config) -> anyhow::Result<Prepared> {
    let of_program = |of: &ProgramCycle| {
        choice(&config, of.begun_by.clone(), &of.cycle, of.model.as_deref().or(config.model.as_deref()))
    };
    let of_every =
        config.cycle.iter().map(|cycle| choice(&config, BegunBy::Every, cycle, config.model.as_deref()));
    let choices = config.programs.iter().map(of_program).chain(of_every).collect::<anyhow::Result<_>>()?;
    Ok(Prepared { cycles: Cycles::new(choices)?, config })
}

/// A configuration with another cycle.
pub fn prepare_cycle(path: &Path, cycle: &Path) -> anyhow::Result<(Config, Choice)> {
    let config = Config::parse(path, &load::read(path)?)?;
    let choice = choice(&config, BegunBy::Every, cycle, config.model.as_deref())?;
    Ok((config, choice))
}

fn choice(config: &Config, begun_by: BegunBy, path: &Path, model: Option<&Path>) -> anyhow::Result<Choice> {
    let cycle_text = load::read(path)?;
    let cycle = Cycle::parse(&path.display().to_string(), &cycle_text)?;
    bar_zero::check(config, &cycle)?;
    let (machine, machine_text) = load::machine_in(path, &cycle.machine)?;
    let model_file = model.map(Path::to_owned);
    let model = match model {
        Some(path) => Model::load(path)?,
        None => Model::base(&machine.name),
    };
    let texts = Texts { machine: machine_text, cycle: cycle_text, config: config.text.clone() };
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    Ok(Choice { begun_by, plan, texts, model, model_file })
}

/// What the service waits for has ended. Left are looks at files and messages to systemd, which may hang for ever: a share on the network
/// that answers at all does so within some seconds.
const LEFT_BEHIND: Duration = Duration::from_secs(5);

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    log_to_stderr();
    private_files::keep();
    let prepared = prepare(&args.config)?;
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let ended = runtime.block_on(async {
        let cancel = CancellationToken::new();
        let stop = cancel.clone();
        let asked_to_stop = asked_to_stop()?;
        tokio::spawn(async move {
            asked_to_stop.await;
            stop.cancel();
        });
        let clock = Arc::new(SystemClock::start());
        let analyst = analyst()?;
        let Prepared { config, cycles } = prepared;
        daemon::serve_on(config, cycles, clock, cancel, Board::default(), analyst).await?;
        Ok(Outcome::Done)
    });
    runtime.shutdown_timeout(LEFT_BEHIND);
    ended
}

/// From now on SIGTERM and Ctrl-C do not end the program; the future is ready after the first of them.
pub fn asked_to_stop() -> anyhow::Result<impl Future<Output = ()>> {
    let mut terminate = signal(SignalKind::terminate()).context("cannot listen for SIGTERM")?;
    let mut interrupt = signal(SignalKind::interrupt()).context("cannot listen for SIGINT")?;
    Ok(async move {
        tokio::select! { _ = terminate.recv() => {}, _ = interrupt.recv() => {} }
    })
}

/// What analyses is this program, whatever path it was started by.
pub fn analyst() -> anyhow::Result<Analyst> {
    Ok(Analyst::Program(std::env::current_exe().context("cannot find the program itself")?))
}

/// Log lines on standard error; `RUST_LOG` chooses, the usual level is info.
pub fn log_to_stderr() {
    let usual = Targets::new().with_default(LevelFilter::INFO).with_target("rumqttc", LevelFilter::WARN);
    let chosen: Option<Targets> = std::env::var("RUST_LOG").ok().and_then(|text| text.parse().ok());
    let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr);
    // Colours are for a screen: in a file or a pipe they are characters that no search finds a word through.
    let lines = if std::io::stderr().is_terminal() { lines } else { lines.with_ansi(false) };
    tracing_subscriber::registry().with(lines).with(chosen.unwrap_or(usual)).init();
}
