//! Our program's side: a real acquisition with one CANopen network on an interface.

use crate::LIMIT;
use crate::seen::Seen;
use anyhow::{Context, bail, ensure};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, SessionEnd, parse_devices, start};
use trunnion_core::Clock;
use trunnion_core::reading::{Message, ProbeReading, Reading};
use trunnion_service::clock::SystemClock;

/// Messages of the network, and the clock they are on.
pub struct Session {
    acquisition: Acquisition,
    clock: Arc<SystemClock>,
    epoch: u32,
}

impl Session {
    /// Starts reading.
    pub fn start(interface: &str, sync_ms: u32, nodes: &str) -> Self {
        let text = format!(
            "[[device]]\nname = \"bus\"\ndriver = \"canopen-socketcan\"\ninterface = \"{interface}\"\n\
             sync_ms = {sync_ms}\nsilence_ms = 1500\nnodes = {nodes}\n"
        );
        let devices = parse_devices("guest.toml", &text).expect("the configuration is good");
        let clock = Arc::new(SystemClock::start());
        let acquisition = start(devices, clock.clone(), CancellationToken::new(), QUEUE_LENGTH);
        Self { acquisition, clock, epoch: 0 }
    }

    /// Reads until so many SYNCs were answered by all channels: each has one moment for all of them, not later than now,
    /// and the moments go forward with the index.
    pub async fn read_syncs(&mut self, count: usize, channels: usize) -> anyhow::Result<Vec<ProbeReading>> {
        let (mut by_sync, mut all) = (BTreeMap::<u64, Vec<ProbeReading>>::new(), Vec::new());
        let begun = Instant::now();
        while by_sync.values().filter(|values| values.len() == channels).count() < count {
            ensure!(
                begun.elapsed() < LIMIT,
                "{} SYNCs, the last {:?}",
                by_sync.len(),
                by_sync.last_key_value()
            );
            let message = self.next().await?;
            let Reading::Probe(reading) = message.reading else { continue };
            if message.epoch != self.epoch {
                // A new connection counts again: the emulated processor was stopped for longer than the silence allowed.
                self.epoch = message.epoch;
                by_sync.clear();
            }
            ensure!(reading.arrival <= self.clock.now(), "stamped after now: {reading:?}");
            by_sync.entry(reading.sequence).or_default().push(reading);
            all.push(reading);
        }
        let mut last_ticks = None;
        for (sync, values) in &by_sync {
            let ticks = values[0].device_ticks;
            ensure!(values.iter().all(|value| value.device_ticks == ticks), "SYNC {sync}: {values:?}");
            ensure!(values.len() <= channels, "SYNC {sync} was answered twice: {}", brief(values));
            ensure!(last_ticks.is_none_or(|last| last < ticks), "SYNC {sync} goes back: {values:?}");
            last_ticks = Some(ticks);
        }
        let incomplete = by_sync.values().filter(|values| values.len() < channels).count();
        ensure!(incomplete <= by_sync.len() / 10, "{incomplete} of {} SYNCs are incomplete", by_sync.len());
        Ok(all)
    }

    /// Waits for a line of the log; the line.
    pub async fn until_log(&mut self, piece: &str) -> anyhow::Result<String> {
        let fits =
            |message: &Message| matches!(&message.reading, Reading::Log(line) if line.text.contains(piece));
        match self.until(piece, fits).await?.reading {
            Reading::Log(line) => Ok(line.text),
            _ => bail!("{piece}: not a line of the log"),
        }
    }

    /// What comes from now on.
    pub fn seen(&self) -> Seen {
        Seen::from(&self.status())
    }

    /// How many sessions have ended.
    pub fn ends(&self) -> u64 {
        self.status().ends.iter().sum()
    }

    /// Takes what comes until it is so; `is_so` is given how many sessions have ended.
    pub async fn watch(
        &mut self,
        seen: &mut Seen,
        what: &str,
        is_so: impl Fn(&Seen, u64) -> bool,
    ) -> anyhow::Result<()> {
        let mut state = self.acquisition.states[0].clone();
        let begun = Instant::now();
        while !is_so(seen, self.ends()) {
            ensure!(
                begun.elapsed() < LIMIT,
                "{what}: it does not come to that; {:?}, {seen:?}",
                self.status()
            );
            let next = async {
                tokio::select! {
                    message = self.acquisition.messages.recv() => message,
                    _ = state.changed() => None,
                }
            };
            let Ok(message) = timeout(LIMIT, next).await else { continue };
            seen.course.take(&self.status());
            if let Some(message) = message {
                self.note(&message);
                seen.take(&message);
            }
        }
        Ok(())
    }

    /// Waits until a session ends in a way that fits.
    pub async fn end(&self, fits: impl Fn(&SessionEnd) -> bool) -> anyhow::Result<SessionEnd> {
        let mut state = self.acquisition.states[0].clone();
        let found = timeout(LIMIT, state.wait_for(|status| status.last_end.as_ref().is_some_and(&fits)));
        let status =
            found.await.with_context(|| format!("the session goes on: {:?}", self.status()))??.clone();
        status.last_end.context("a session ended without an end")
    }

    /// Waits for readings of a new connection; the reason of the gap before them.
    pub async fn until_epoch_after_gap(&mut self) -> anyhow::Result<String> {
        let epoch = self.epoch;
        let mut reason = None;
        let begun = Instant::now();
        loop {
            ensure!(begun.elapsed() < LIMIT, "no new connection: {:?}", self.status());
            let message = self.next().await?;
            if message.epoch <= epoch {
                continue;
            }
            match message.reading {
                Reading::Gap(gap) => reason = Some(gap.reason),
                Reading::Probe(_) => {
                    self.epoch = message.epoch;
                    return reason.context("readings came without a gap before them");
                }
                _ => {}
            }
        }
    }

    /// Ends it.
    pub async fn stop(self) {
        self.acquisition.stop().await;
    }

    async fn until(&mut self, what: &str, fits: impl Fn(&Message) -> bool) -> anyhow::Result<Message> {
        let begun = Instant::now();
        loop {
            let message = self.next().await?;
            if fits(&message) {
                return Ok(message);
            }
            if begun.elapsed() > LIMIT {
                bail!("{what} does not come; {:?}", self.status());
            }
        }
    }

    async fn next(&mut self) -> anyhow::Result<Message> {
        let message = timeout(LIMIT, self.acquisition.messages.recv()).await;
        let message =
            message.with_context(|| format!("nothing comes: {:?}", self.status()))?.context("it ended")?;
        self.note(&message);
        if matches!(message.reading, Reading::Probe(_)) && self.epoch == 0 {
            self.epoch = message.epoch;
        }
        Ok(message)
    }

    fn note(&self, message: &Message) {
        if let Reading::Log(line) = &message.reading {
            println!("log: {}", line.text);
        }
    }

    /// What the device is doing.
    fn status(&self) -> trunnion_acquire::DeviceStatus {
        self.acquisition.states[0].borrow().clone()
    }
}

fn brief(values: &[ProbeReading]) -> String {
    values.iter().map(|value| format!("channel {} at {} µs; ", value.channel, value.device_ticks)).collect()
}
