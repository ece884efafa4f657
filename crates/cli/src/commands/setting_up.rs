//! What the commands for setting up share: the devices of a configuration, connected, with their latest values.

use super::daemon::{Prepared, with_files};
use crate::load;
use anyhow::{Context, bail};
use std::path::Path;
use std::sync::Arc;
use tokio::time::{Instant, sleep_until};
use tokio_util::sync::CancellationToken;
use trunnion::nest::NestSteps;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, start};
use trunnion_core::channel::instrument_channels;
use trunnion_core::reading::Message;
use trunnion_core::{Clock, NestSide};
use trunnion_service::clock::SystemClock;
use trunnion_service::config::Config;
use trunnion_service::latest::{Latest, Mounted};
use trunnion_service::live::{Plan, TimeBase, Timed};

/// The devices of a configuration, and how its probes stand.
pub struct SettingUp {
    prepared: Prepared,
}

impl SettingUp {
    /// Reads a configuration; `[nest]` may be missing.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = load::read(path)?;
        let prepared = with_files(Config::parse_uncalibrated(path, &text)?)?;
        if prepared.config.devices.is_empty() {
            bail!("{} has no [[device]]; `trunnion devices` finds them", path.display());
        }
        Ok(Self { prepared })
    }

    /// How the probes stand; `None` before the nest is calibrated.
    pub fn mounted(&self) -> Option<Mounted> {
        self.plan().filter(|_| self.prepared.config.has_nest).map(Mounted::of)
    }

    /// Of the first cycle: all are of one machine.
    fn plan(&self) -> Option<&Plan> {
        self.prepared.cycles.first().map(|choice| &choice.plan)
    }

    /// Dwells of this machine as read by its three probes.
    pub fn steps(&self) -> anyhow::Result<NestSteps> {
        let plan = self.plan().context("the configuration names no cycle, so no machine")?;
        let channels = instrument_channels(&plan.channels, false)
            .context("the configuration lacks probe-1, probe-2, probe-3; add [[device]] with these roles")?;
        let side: NestSide = plan.cycle.setups[0].nest;
        Ok(NestSteps::new(plan.machine.clone(), side, &channels))
    }

    /// Connects the devices, on the current runtime, until Control-C or for so many seconds.
    pub fn connect(&self, seconds: Option<f64>) -> Connected {
        let devices = self.prepared.config.devices.clone();
        let (clock, cancel) = (Arc::new(SystemClock::start()), CancellationToken::new());
        let stop = cancel.clone();
        tokio::spawn(async move {
            // Without the signal the time ends it.
            if tokio::signal::ctrl_c().await.is_ok() {
                stop.cancel();
            }
        });
        let acquisition = start(devices.clone(), clock.clone(), cancel.clone(), QUEUE_LENGTH);
        let latest = Latest::new(&devices, acquisition.states.clone(), clock.clone());
        if let Some(mounted) = self.mounted() {
            latest.set_mounted(mounted);
        }
        let end = seconds.map(|seconds| Instant::now() + std::time::Duration::from_secs_f64(seconds));
        let timebase = TimeBase::new(clock.now());
        Connected { acquisition, latest, timebase, end, cancel }
    }
}

/// Running devices.
pub struct Connected {
    acquisition: Acquisition,
    /// Their latest values.
    pub latest: Latest,
    timebase: TimeBase,
    end: Option<Instant>,
    cancel: CancellationToken,
}

impl Connected {
    /// The next message, which is among the latest values then; `None` when it is over. Cancel safe.
    pub async fn message(&mut self) -> Option<Message> {
        let end = self.end;
        let message = tokio::select! {
            biased;
            () = self.cancel.cancelled() => None,
            () = async { match end { Some(end) => sleep_until(end).await, None => std::future::pending().await } } => None,
            message = self.acquisition.messages.recv() => message,
        }?;
        self.latest.take(&message);
        Some(message)
    }

    /// Hands a message to the dwells.
    pub fn step(&mut self, message: &Message, steps: &mut NestSteps) {
        match self.timebase.translate(message) {
            Some(Timed::Probe(sample)) => steps.probe(&sample),
            Some(Timed::Axes(sample)) => steps.axes(&sample),
            _ => {}
        }
    }

    /// Stops the devices.
    pub async fn stop(self) {
        self.acquisition.stop().await;
    }
}
