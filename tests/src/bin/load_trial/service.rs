//! The other process: the service as `trunnion daemon` runs it, stopped by the trial when the recording is finished.

use anyhow::Context;
use std::path::Path;
use std::sync::Arc;
use tokio_util::sync::CancellationToken;
use tracing_subscriber::filter::LevelFilter;
use trunnion_acquire::config::channels;
use trunnion_cycles::Cycle;
use trunnion_effects::Model;
use trunnion_machine::shipped;
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::cycles::Cycles;
use trunnion_service::daemon::{QUEUES, Texts, serve};
use trunnion_service::live::Plan;

/// Runs until it is stopped.
pub fn run(path: &Path) -> anyhow::Result<()> {
    let lines = tracing_subscriber::fmt().with_max_level(LevelFilter::INFO);
    lines.with_ansi(false).with_writer(std::io::stderr).init();
    let read = |path: &Path| {
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
    };
    let config = Config::parse(path, &read(path)?)?;
    let cycle_text = read(config.cycle.as_deref().context("a cycle for every program")?)?;
    let cycle = Cycle::parse("cycle.toml", &cycle_text)?;
    let machine = shipped::machine(&cycle.machine).context("the machine is shipped")?;
    let machine_text = shipped::FILES.iter().find(|(name, _)| *name == cycle.machine).map(|(_, text)| *text);
    let model = Model::base(&machine.name).into();
    let plan = Plan { machine, cycle, nest: config.nest, channels: channels(&config.devices) };
    let texts = Texts {
        machine: machine_text.unwrap_or_default().into(),
        cycle: cycle_text,
        config: config.text.clone(),
    };
    let runtime = tokio::runtime::Runtime::new().context("cannot start the runtime")?;
    let clock = Arc::new(SystemClock::start());
    runtime.block_on(serve(config, Cycles::one(plan, texts, model)?, clock, CancellationToken::new()))?;
    Ok(())
}

/// The most that waited in the service's queues, messages.
#[derive(Clone, Copy, Debug)]
pub struct Queues {
    /// From the drivers to the cycle, of 32 768.
    pub drivers: u64,
    /// From the cycle to the recorder, of 32 768.
    pub recorder: u64,
}

impl Queues {
    /// From the line the service writes at the end of a cycle.
    pub fn of_log(log: &str) -> Option<Self> {
        let line = log.lines().rev().find(|line| line.contains(QUEUES))?;
        let number = |key: &str| {
            let text = line.split_whitespace().find_map(|word| word.strip_prefix(key))?;
            text.parse().ok()
        };
        Some(Self { drivers: number("drivers=")?, recorder: number("recorder=")? })
    }
}
