//! One cycle, live: messages of the devices become run time, recorded items and points.
//!
//! Everything is recorded before it is interpreted. The points that come out are recorded too.

mod recorded;
mod remounts;
mod tally;

use crate::latest::Latest;
use remounts::{FIRST_MOTION_S, Remounts};
use std::sync::Arc;
use std::time::Duration;
use tally::Tally;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use trunnion::join::UNDER_WAY;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{Acquisition, DeviceConfig, DeviceStatus};
use trunnion_core::{Channel, Clock, Event, Gap, HostTime, Quality, Role};
use trunnion_record::{Item, RecordSender, Temperature};
use trunnion_sync::forming::Forming;
use trunnion_sync::{Bound, CycleEvent, EndReason};

pub use recorded::gaps_of;
pub use trunnion_sync::cycle_bounds::Pattern;
pub use trunnion_sync::plan::{Plan, PlanError, check};
pub use trunnion_sync::{CycleBounds, Progress, TimeBase, Timed};

/// How a measured cycle ended.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Points recorded. They are not kept: a cycle may last for hours.
    pub points: Counted,
    /// Why it ended.
    pub reason: EndReason,
    /// Holes in what was asked; the recording holds all, those while the ball was mounted again too.
    pub gaps: Vec<Gap>,
    /// Most messages that waited to be taken.
    pub most_waiting: usize,
}

/// Points of a cycle by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Good ones.
    pub read: u64,
    /// Without a reading that settled.
    pub unsettled: u64,
    /// Poses that were not stood at, or without a value of every probe.
    pub missing: u64,
}

impl Counted {
    fn count(&mut self, quality: Quality) {
        *match quality {
            Quality::Good => &mut self.read,
            Quality::Unsettled => &mut self.unsettled,
            Quality::NoReading => &mut self.missing,
        } += 1;
    }
}

/// A cycle that has begun.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// When its beginning was seen.
    pub at: HostTime,
    /// By what.
    pub why: String,
    /// The program that the controller showed; empty when it showed none.
    pub program: String,
    /// The program ran already when the controller was first asked.
    pub under_way: bool,
    /// Temperature channels that had reported a value by then; later ones take no part in the run.
    pub temperature_channels: Vec<String>,
}

/// The controller shows the end before the last samples are through: how long to go on, s.
const AFTERMATH_S: f64 = 1.0;
/// A channel without a sample for so long at the end of a run was away, s; the slowest indicators speak every second.
const AWAY_S: f64 = 2.5;
/// With no message of any device for so long the cycle ends.
const SILENCE: Duration = Duration::from_secs(60);

/// Receives how far a cycle is.
pub type OnProgress<'a> = &'a mut (dyn FnMut(Progress) + Send);

/// The devices of a running service, their clocks, and the rule by which cycles begin and end.
pub struct Live {
    acquisition: Acquisition,
    timebase: TimeBase,
    bounds: CycleBounds,
    latest: Latest,
    /// Temperature channels that have reported a value.
    temperature_channels: Vec<String>,
    /// A cycle that began while the one before it was being measured.
    next: Option<Start>,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
}

impl Live {
    /// Starts a session for every device, on the current tokio runtime. Cancelling `cancel` stops them.
    pub fn start(
        devices: Vec<DeviceConfig>,
        bounds: CycleBounds,
        clock: Arc<dyn Clock>,
        cancel: CancellationToken,
    ) -> Self {
        let configured = devices.clone();
        let acquisition = trunnion_acquire::start(devices, clock.clone(), cancel.clone(), QUEUE_LENGTH);
        let latest = Latest::new(&configured, acquisition.states.clone(), clock.clone());
        let (timebase, temperature_channels) = (TimeBase::new(clock.now()), Vec::new());
        Self { acquisition, timebase, bounds, latest, temperature_channels, next: None, clock, cancel }
    }

    /// Status of each device, in the order of the configuration.
    pub fn states(&self) -> Vec<watch::Receiver<DeviceStatus>> {
        self.acquisition.states.clone()
    }

    /// The latest values, to be shown while this measures or waits.
    pub fn latest(&self) -> &Latest {
        &self.latest
    }

    /// The clocks of the host.
    pub fn clock(&self) -> &Arc<dyn Clock> {
        &self.clock
    }

    /// Stops all sessions and waits for them.
    pub async fn stop(self) {
        self.acquisition.stop().await;
    }

    /// Waits until a cycle begins; one that began while another was measured has begun. `None` when cancelled or when
    /// all devices are gone.
    pub async fn wait_for_start(&mut self) -> Option<Start> {
        loop {
            if let Some(start) = self.next.take() {
                return Some(start);
            }
            let message = tokio::select! {
                biased;
                () = self.cancel.cancelled() => return None,
                message = self.acquisition.messages.recv() => message?,
            };
            self.latest.take(&message);
            let timed = self.timebase.translate(&message);
            self.note_channel(timed.as_ref());
            if let Some(Bound::Begins { at, why, program, under_way }) = self.bounds.take(&message.reading) {
                self.next = Some(self.started(at, why, program, under_way));
            }
        }
    }

    fn started(&self, at: HostTime, why: String, program: String, under_way: bool) -> Start {
        Start { at, why, program, under_way, temperature_channels: self.temperature_channels.clone() }
    }

    fn note_channel(&mut self, timed: Option<&Timed>) {
        if let Some(Timed::Temperature { name, .. }) = timed
            && !self.temperature_channels.contains(name)
        {
            self.temperature_channels.push(name.clone());
        }
    }

    /// Measures one cycle until it ends. Run time zero is `start`.
    ///
    /// # Errors
    /// When the plan cannot be measured.
    pub async fn measure(
        &mut self,
        plan: &Plan,
        start: &Start,
        recorder: &RecordSender,
        progress: OnProgress<'_>,
    ) -> Result<Measured, PlanError> {
        self.timebase.begin_run(start.at);
        self.latest.set_recorder(recorder.clone());
        self.bounds = std::mem::take(&mut self.bounds).with_first_pose(plan.first_pose());
        let mut measurement = Measurement::new(plan, &start.temperature_channels, recorder)?;
        for doubt in self.latest.not_ready(&check(plan)?) {
            let doubt = Event { time_s: 0.0, kind: "warning".into(), text: doubt.to_string() };
            measurement.record(Item::Event(doubt), self.clock.now());
        }
        let begun = Event { time_s: 0.0, kind: "cycle-start".into(), text: start.why.clone() };
        measurement.record(Item::Event(begun), self.clock.now());
        if start.under_way {
            let text = "the program ran already when the service began to look".into();
            let under_way = Event { time_s: 0.0, kind: UNDER_WAY.into(), text };
            measurement.record(Item::Event(under_way), self.clock.now());
        }
        let mut shown = None;
        while measurement.forming.ended().is_none() {
            let messages = &mut self.acquisition.messages;
            let message = tokio::select! {
                biased;
                () = self.cancel.cancelled() => None,
                received = tokio::time::timeout(SILENCE, messages.recv()) => match received {
                    Ok(message) => message,
                    Err(_) => {
                        measurement.finish(EndReason::NoMotion, self.clock.now());
                        break;
                    }
                },
            };
            measurement.most_waiting = measurement.most_waiting.max(messages.len() + 1);
            let Some(message) = message else {
                measurement.finish(EndReason::Stopped, self.clock.now());
                break;
            };
            self.latest.take(&message);
            match self.bounds.take(&message.reading) {
                Some(Bound::Ends { at, why }) => {
                    measurement.end_seen(self.timebase.seconds(at), why, self.clock.now());
                }
                Some(Bound::Begins { at, why, program, under_way }) => {
                    // What comes from here on is the next cycle's.
                    measurement.finish(EndReason::ControllerEnded, self.clock.now());
                    self.next = Some(self.started(at, why, program, under_way));
                    break;
                }
                None => {}
            }
            measurement.forming.set_held(self.bounds.is_held());
            let timed = self.timebase.translate(&message);
            self.note_channel(timed.as_ref());
            measurement.tally.take(&message);
            measurement.take(timed, &mut self.timebase, self.clock.now());
            let now = measurement.forming.progress();
            if shown.replace(now.done) != Some(now.done) {
                self.latest.set_cycle(Some((plan.cycle.name.as_str(), now)));
                progress(now);
            }
        }
        self.latest.set_cycle(None);
        if self.next.is_none() {
            self.bounds.ended_otherwise();
        }
        measurement.record_open_gaps(self.clock.now());
        measurement.record_tally(self.clock.now());
        Ok(measurement.into_measured())
    }
}

/// A cycle being measured.
struct Measurement<'m> {
    forming: Forming,
    /// What the last sample gave, until it is recorded.
    formed: Vec<CycleEvent>,
    recorder: &'m RecordSender,
    channels: &'m [Channel],
    points: Counted,
    gaps: Vec<Gap>,
    remounts: Remounts,
    tally: Tally,
    temperature_channels: Vec<String>,
    controller_ended_s: Option<f64>,
    /// Newest sample of every channel, then of the axes, s.
    newest_s: Vec<f64>,
    most_waiting: usize,
}

impl<'m> Measurement<'m> {
    fn new(
        plan: &'m Plan,
        temperature_channels: &[String],
        recorder: &'m RecordSender,
    ) -> Result<Self, PlanError> {
        Ok(Self {
            forming: Forming::new(plan, temperature_channels.len())?,
            formed: Vec::new(),
            recorder,
            channels: &plan.channels,
            points: Counted::default(),
            gaps: Vec::new(),
            remounts: Remounts::default(),
            tally: Tally::default(),
            temperature_channels: temperature_channels.to_vec(),
            controller_ended_s: None,
            newest_s: vec![0.0; plan.channels.len() + 1],
            most_waiting: 0,
        })
    }

    fn take(&mut self, timed: Option<Timed>, timebase: &mut TimeBase, now: HostTime) {
        let Some(timed) = timed else { return };
        for (device, jump) in timebase.take_jumps() {
            let named = self.channels.iter().find(|channel| channel.device == device);
            let source = named.map_or_else(|| "controller".into(), |channel| channel.name.clone());
            self.gap(timebase.jump_gap(&source, &jump), now);
        }
        match timed {
            Timed::Probe(sample) => {
                if let Some(newest_s) = self.newest_s.get_mut(usize::from(sample.channel)) {
                    *newest_s = newest_s.max(sample.time_s);
                }
                self.record(Item::Probe(sample), now);
                self.forming.probe(&sample, &mut self.formed);
            }
            Timed::Axes(sample) => {
                if let Some(newest_s) = self.newest_s.last_mut() {
                    *newest_s = newest_s.max(sample.time_s);
                }
                self.record(Item::Axes(sample), now);
                self.forming.axes(&sample, &mut self.formed);
            }
            Timed::Gap(gap) => self.gap(gap, now),
            Timed::Temperature { name, degc, time_s } => {
                if let Some(channel) = self.temperature_channels.iter().position(|known| *known == name) {
                    self.forming.temperature(channel, degc);
                    let channel = channel as u16;
                    self.record(Item::Temperature(Temperature { time_s, channel, value_degc: degc }), now);
                }
            }
            Timed::Event(event) => self.record(Item::Event(event), now),
        }
        self.keep(now);
        if self.controller_ended_s.is_some_and(|ended_s| self.forming.newest_s() > ended_s + AFTERMATH_S) {
            self.finish(EndReason::ControllerEnded, now);
        }
    }

    /// The controller, or a long stand, shows the end; samples under way are still taken.
    fn end_seen(&mut self, time_s: f64, why: String, now: HostTime) {
        self.record(Item::Event(Event { time_s, kind: "end-seen".into(), text: why }), now);
        self.controller_ended_s = Some(time_s);
    }

    /// A device that is away when the run ends would close its gap only in the next one.
    fn record_open_gaps(&mut self, now: HostTime) {
        let end_s = self.forming.newest_s();
        let samples = |channel: &&Channel| channel.role != Role::Temperature;
        let named = self.channels.iter().enumerate().filter(|(_, channel)| samples(channel));
        let sources = named.map(|(k, channel)| (k, channel.name.clone()));
        let sources: Vec<_> = sources.chain([(self.channels.len(), "controller".into())]).collect();
        for (k, source) in sources {
            let from_s = self.newest_s[k];
            if end_s - from_s > AWAY_S {
                let reason = "no sample until the end of the run; the state of the device says why".into();
                self.gap(Gap { source, from_s, to_s: end_s, lost_samples: None, reason }, now);
            }
        }
    }

    fn record_tally(&mut self, now: HostTime) {
        let (counted, unexplained) = self.tally.result(self.channels, self.forming.newest_s());
        counted.into_iter().for_each(|event| self.record(Item::Event(event), now));
        unexplained.into_iter().for_each(|gap| self.gap(gap, now));
    }

    fn finish(&mut self, reason: EndReason, now: HostTime) {
        self.forming.finish(reason, &mut self.formed);
        self.keep(now);
    }

    /// Records what was formed.
    fn keep(&mut self, now: HostTime) {
        let mut formed = std::mem::take(&mut self.formed);
        for event in formed.drain(..) {
            if let CycleEvent::Point { point, time_s, .. } = &event {
                self.remounts.take(point, *time_s);
            }
            match event.into_point() {
                Ok(point) => {
                    self.points.count(point.quality);
                    self.record(Item::Point(point), now);
                }
                Err(event) => self.record(Item::Event(event), now),
            }
        }
        self.formed = formed;
    }

    fn gap(&mut self, gap: Gap, now: HostTime) {
        self.record(Item::Gap(gap.clone()), now);
        // What was missing before the program ran is no loss of this run.
        if gap.to_s > FIRST_MOTION_S {
            self.gaps.push(gap);
        }
    }

    /// The recorder counts what it cannot take and records it as a gap itself; here nothing more can be done.
    fn record(&self, item: Item, arrival: HostTime) {
        if !self.recorder.try_send(item, arrival) {
            tracing::debug!("the recorder is full; the loss is counted in the recording");
        }
    }

    fn into_measured(self) -> Measured {
        let reason = self.forming.ended().unwrap_or(EndReason::Stopped);
        let gaps = self.gaps.into_iter().filter(|gap| !self.remounts.hold(gap)).collect();
        Measured { points: self.points, reason, gaps, most_waiting: self.most_waiting }
    }
}
