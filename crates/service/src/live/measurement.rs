//! One cycle while it is measured: what comes in is recorded, then formed into points; holes are counted.

use super::bar_length::BarLength;
use super::measured::{Counted, Measured};
use super::tally::Tally;
use trunnion::gaps::Gaps;
use trunnion_core::{Channel, Event, Gap, HostTime, Role, Setup};
use trunnion_record::{Item, RecordSender, Temperature};
use trunnion_sync::forming::Forming;
use trunnion_sync::plan::{Plan, PlanError};
use trunnion_sync::{CycleEvent, EndReason, TimeBase, Timed};

/// The controller shows the end before the last samples are through: how long to go on, s.
const AFTERMATH_S: f64 = 1.0;
/// A channel without a sample for so long at the end of a run was away, s; the slowest indicators speak every second.
const AWAY_S: f64 = 2.5;

/// A cycle being measured.
pub(super) struct Measurement<'m> {
    pub(super) forming: Forming,
    /// What the last sample gave, until it is recorded.
    formed: Vec<CycleEvent>,
    recorder: &'m RecordSender,
    channels: &'m [Channel],
    setups: &'m [Setup],
    bar_length: BarLength,
    /// What the last sample put in doubt.
    doubt: Option<String>,
    points: Counted,
    gaps: Gaps,
    pub(super) tally: Tally,
    temperature_channels: Vec<String>,
    controller_ended_s: Option<f64>,
    /// Newest sample of every channel, then of the axes, s.
    newest_s: Vec<f64>,
    pub(super) most_waiting: usize,
}

impl<'m> Measurement<'m> {
    pub(super) fn new(
        plan: &'m Plan,
        temperature_channels: &[String],
        recorder: &'m RecordSender,
    ) -> Result<Self, PlanError> {
        Ok(Self {
            forming: Forming::new(plan, temperature_channels.len())?,
            formed: Vec::new(),
            recorder,
            channels: &plan.channels,
            setups: &plan.cycle.setups,
            bar_length: BarLength::default(),
            doubt: None,
            points: Counted::default(),
            gaps: Gaps::default(),
            tally: Tally::default(),
            temperature_channels: temperature_channels.to_vec(),
            controller_ended_s: None,
            newest_s: vec![0.0; plan.channels.len() + 1],
            most_waiting: 0,
        })
    }

    pub(super) fn take(&mut self, timed: Option<Timed>, timebase: &mut TimeBase, now: HostTime) {
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
    pub(super) fn end_seen(&mut self, time_s: f64, why: String, now: HostTime) {
        self.record(Item::Event(Event { time_s, kind: "end-seen".into(), text: why }), now);
        self.controller_ended_s = Some(time_s);
    }

    /// The program of a cycle that a person began before it.
    pub(super) fn program_seen(&self, why: String, now: HostTime) {
        let time_s = self.forming.newest_s();
        self.record(Item::Event(Event { time_s, kind: "program-seen".into(), text: why }), now);
    }

    /// A person ends it.
    pub(super) fn aborted(&mut self, now: HostTime) {
        let (time_s, text) = (self.forming.newest_s(), "a person ended the cycle".into());
        self.record(Item::Event(Event { time_s, kind: "aborted".into(), text }), now);
        self.finish(EndReason::Stopped, now);
    }

    /// What was put in doubt since this was asked last.
    pub(super) fn take_doubt(&mut self) -> Option<String> {
        self.doubt.take()
    }

    pub(super) fn has_no_point(&self) -> bool {
        self.points == Counted::default()
    }

    /// Holes so far.
    pub(super) fn gaps(&self) -> &[Gap] {
        self.gaps.so_far()
    }

    /// A device that is away when the run ends would close its gap only in the next one.
    pub(super) fn record_open_gaps(&mut self, now: HostTime) {
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

    pub(super) fn record_tally(&mut self, now: HostTime) {
        let (counted, unexplained) = self.tally.result(self.channels, self.forming.newest_s());
        counted.into_iter().for_each(|event| self.record(Item::Event(event), now));
        unexplained.into_iter().for_each(|gap| self.gap(gap, now));
    }

    pub(super) fn finish(&mut self, reason: EndReason, now: HostTime) {
        self.forming.finish(reason, &mut self.formed);
        self.keep(now);
    }

    /// Records what was formed.
    fn keep(&mut self, now: HostTime) {
        let mut formed = std::mem::take(&mut self.formed);
        for event in formed.drain(..) {
            if let CycleEvent::Point { point, .. } = &event {
                self.gaps.pose(point);
                if let Some(doubt) = self.bar_length.doubt(self.setups, point) {
                    tracing::warn!("{doubt}");
                    let (time_s, kind) = (self.forming.newest_s(), "warning".into());
                    self.record(Item::Event(Event { time_s, kind, text: doubt.clone() }), now);
                    self.doubt = Some(doubt);
                }
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
        self.gaps.take(gap);
    }

    /// The recorder counts what it cannot take and records it as a gap itself; here nothing more can be done.
    pub(super) fn record(&self, item: Item, arrival: HostTime) {
        if !self.recorder.try_send(item, arrival) {
            tracing::debug!("the recorder is full; the loss is counted in the recording");
        }
    }

    pub(super) fn into_measured(self) -> Measured {
        let reason = self.forming.ended().unwrap_or(EndReason::Stopped);
        let gaps = self.gaps.finish();
        Measured { points: self.points, reason, gaps, most_waiting: self.most_waiting }
    }
}
