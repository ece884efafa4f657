//! One cycle, live: messages of the devices become run time, recorded items, aligned samples and points.
//!
//! Everything is recorded before it is interpreted. The points that come out are recorded too, so that a replay
//! works on the same numbers.

use nalgebra::Vector3;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::config::{Channel, instrument_channels};
use trunnion_acquire::{
    AlignLimits, Aligned, Aligner, Bound, CycleBounds, CycleEvent, EndReason, Message, NestCalibration,
    Progress, StaticCycle, StaticRules, SweepCycle, SweepRules, TimeBase, Timed,
};
use trunnion_machine::Machine;
use trunnion_measurement::cycle::Motion;
use trunnion_measurement::{Cycle, Event, Gap, InstrumentKind, Point, Quality, Run};
use trunnion_record::{Item, RecordSender, Temperature};
use trunnion_units::{AxisLetter, Clock, HostTime};

/// What is measured and how.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The machine.
    pub machine: Machine,
    /// The cycle.
    pub cycle: Cycle,
    /// Probe directions.
    pub nest: NestCalibration,
    /// Channels of all devices.
    pub channels: Vec<Channel>,
}

/// A plan that cannot be measured.
#[derive(Clone, Debug, thiserror::Error)]
pub enum PlanError {
    /// The linear axes cannot follow the ball.
    #[error(
        "machine {machine} cannot bring its tool to the ball with its linear axes; check the machine file"
    )]
    CannotFollow {
        /// Machine name.
        machine: String,
    },
    /// A probe is missing.
    #[error(
        "the cycle measures with {instrument}, but the configuration lacks {needed}; add [[device]] with these roles"
    )]
    NoChannels {
        /// Instrument name.
        instrument: &'static str,
        /// Roles needed.
        needed: &'static str,
    },
    /// Something the service cannot read from its own devices.
    #[error(
        "cycle {cycle} measures with {what}, which is not read live; measure with its own software and bring the points with `trunnion import`"
    )]
    NotLive {
        /// Cycle name.
        cycle: String,
        /// What is not read live.
        what: String,
    },
    /// Two kinds of instrument.
    #[error("cycle {cycle} mixes instruments; measure each instrument in a cycle of its own")]
    MixedInstruments {
        /// Cycle name.
        cycle: String,
    },
}

/// How a measured cycle ended.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its points as a run.
    pub run: Run,
    /// Why it ended.
    pub reason: EndReason,
    /// Holes in the data.
    pub gaps: Vec<Gap>,
}

/// A cycle that has begun.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// When its beginning was seen.
    pub at: HostTime,
    /// By what.
    pub why: String,
    /// Temperature channels that had told a value by then; later ones take no part in the run.
    pub temperature_channels: Vec<String>,
}

/// The controller shows the end before the last samples are through: how long to go on, s.
const AFTERMATH_S: f64 = 1.0;
/// No program moves sooner after its start, s.
const FIRST_MOTION_S: f64 = 0.05;
/// With no message of any device for so long the cycle ends.
const SILENCE: Duration = Duration::from_secs(60);

enum Reader {
    Static(Box<StaticCycle>),
    Sweep(Box<SweepCycle>),
}

impl Reader {
    fn push(&mut self, step: &Aligned) -> Vec<CycleEvent> {
        match self {
            Self::Static(cycle) => cycle.push(step),
            Self::Sweep(cycle) => sweep_events(cycle.push(step)),
        }
    }

    fn finish(&mut self, reason: EndReason, time_s: f64) -> Vec<CycleEvent> {
        match self {
            Self::Static(cycle) => cycle.finish(reason, time_s),
            Self::Sweep(cycle) => {
                let mut events = sweep_events(cycle.finish());
                events.push(CycleEvent::Ended { reason, time_s });
                events
            }
        }
    }

    fn set_temperature(&mut self, channel: usize, degc: f64) {
        match self {
            Self::Static(cycle) => cycle.set_temperature(channel, degc),
            Self::Sweep(cycle) => cycle.set_temperature(channel, degc),
        }
    }

    /// Samples of steady turning that became no point, in words; `None` when there were none.
    fn left_out(&self) -> Option<String> {
        let Self::Sweep(cycle) = self else { return None };
        let (incomplete, unplanned) = (cycle.incomplete(), cycle.unplanned());
        (incomplete + unplanned > 0).then(|| {
            format!("{incomplete} samples lack a channel, {unplanned} belong to no pass of the cycle")
        })
    }

    fn progress(&self) -> Progress {
        match self {
            Self::Static(cycle) => cycle.progress(),
            Self::Sweep(cycle) => cycle.progress(),
        }
    }
}

/// The points of a sweep belong to no pose of a list.
fn sweep_events(point: Option<Point>) -> Vec<CycleEvent> {
    let event = |point: Point| {
        let time_s = point.state.time_s.unwrap_or(0.0);
        CycleEvent::Point { pose: 0, point, time_s }
    };
    point.into_iter().map(event).collect()
}

/// A cycle being measured.
struct Measurement {
    aligner: Aligner,
    reader: Reader,
    /// Reading of the first good point of each setup: only changes from there are measured (S1 eq. 14).
    zero_mm: Vec<Option<Vector3<f64>>>,
    points: Vec<Point>,
    gaps: Vec<Gap>,
    temperature_channels: Vec<String>,
    controller_ended_s: Option<f64>,
    newest_s: f64,
    ended: Option<EndReason>,
}

/// Checks that the configured channels can measure the cycle.
///
/// # Errors
/// When they cannot, or when the machine cannot follow the ball.
pub fn check(plan: &Plan) -> Result<Vec<u16>, PlanError> {
    let kind = plan.cycle.setups[0].instrument;
    if plan.cycle.setups.iter().any(|setup| setup.instrument != kind) {
        return Err(PlanError::MixedInstruments { cycle: plan.cycle.name.clone() });
    }
    let (bar, needed) = match kind {
        InstrumentKind::BallBar => (true, "bar"),
        InstrumentKind::RTest => (false, "probe-1, probe-2, probe-3"),
        other => {
            let cycle = plan.cycle.name.clone();
            return Err(PlanError::NotLive { cycle, what: format!("the instrument {}", other.name()) });
        }
    };
    if let Motion::Path { .. } = plan.cycle.motion {
        let cycle = plan.cycle.name.clone();
        return Err(PlanError::NotLive { cycle, what: "a curve of several axes".into() });
    }
    let instrument = kind.name();
    plan.cycle
        .poses(&plan.machine)
        .ok_or_else(|| PlanError::CannotFollow { machine: plan.machine.name.clone() })?;
    instrument_channels(&plan.channels, bar).ok_or(PlanError::NoChannels { instrument, needed })
}

/// Waits until a cycle begins, by the rule of `bounds`. `None` when cancelled or when all devices are gone.
pub async fn wait_for_start(
    messages: &mut mpsc::Receiver<Message>,
    timebase: &mut TimeBase,
    bounds: &mut CycleBounds,
    cancel: &CancellationToken,
) -> Option<Start> {
    bounds.ended_otherwise();
    let mut temperature_channels: Vec<String> = Vec::new();
    loop {
        let message = tokio::select! {
            biased;
            () = cancel.cancelled() => return None,
            message = messages.recv() => message?,
        };
        if let Some(Timed::Temperature { name, .. }) = timebase.translate(&message)
            && !temperature_channels.contains(&name)
        {
            temperature_channels.push(name);
        }
        if let Some(Bound::Begins { at, why }) = bounds.take(&message.reading) {
            return Some(Start { at, why, temperature_channels });
        }
    }
}

/// Measures one cycle until it ends. Run time zero is `start`.
///
/// # Errors
/// When the plan cannot be measured.
#[expect(clippy::too_many_arguments, reason = "the parts of a running service, borrowed separately")]
pub async fn measure(
    plan: &Plan,
    name: &str,
    start: &Start,
    messages: &mut mpsc::Receiver<Message>,
    timebase: &mut TimeBase,
    bounds: &mut CycleBounds,
    recorder: &RecordSender,
    clock: &Arc<dyn Clock>,
    cancel: &CancellationToken,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Measured, PlanError> {
    let mut measurement = Measurement::new(plan, &start.temperature_channels)?;
    let start_s = timebase.seconds(start.at);
    let begun = Event { time_s: 0.0, kind: "cycle-start".into(), text: start.why.clone() };
    record(recorder, Item::Event(begun), clock.now());
    let mut last_progress = 0;
    while measurement.ended.is_none() {
        let message = tokio::select! {
            biased;
            () = cancel.cancelled() => None,
            received = tokio::time::timeout(SILENCE, messages.recv()) => match received {
                Ok(message) => message,
                Err(_) => {
                    measurement.finish(EndReason::NoMotion, recorder, clock.now());
                    break;
                }
            },
        };
        let Some(message) = message else {
            measurement.finish(EndReason::Stopped, recorder, clock.now());
            break;
        };
        if let Some(Bound::Ends { at, why }) = bounds.take(&message.reading) {
            measurement.told_end(timebase.seconds(at) - start_s, why, recorder, clock.now());
        }
        measurement.take(&message, start_s, timebase, recorder, clock.now());
        let now = measurement.reader.progress();
        if now.done != last_progress {
            last_progress = now.done;
            progress(now);
        }
    }
    Ok(measurement.into_measured(plan, name))
}

impl Measurement {
    fn new(plan: &Plan, temperature_channels: &[String]) -> Result<Self, PlanError> {
        let channels = check(plan)?;
        let axes: Vec<AxisLetter> = plan.machine.axes().map(|axis| axis.letter).collect();
        let calibrations = vec![plan.nest; plan.cycle.setups.len()];
        let reader = match &plan.cycle.motion {
            Motion::Static { settle, .. } | Motion::Line { settle, .. } => {
                let poses = plan.cycle.poses(&plan.machine).unwrap_or_default();
                Reader::Static(Box::new(StaticCycle::new(
                    poses,
                    StaticRules::new(*settle).with_wait(plan.cycle.rounds.wait_s),
                    calibrations,
                    axes,
                    temperature_channels.len(),
                )))
            }
            Motion::Path { .. } => {
                let cycle = plan.cycle.name.clone();
                return Err(PlanError::NotLive { cycle, what: "a curve of several axes".into() });
            }
            Motion::OnTheFly { axis, from_to_rad, .. } => {
                let rules = SweepRules::new(*axis, *from_to_rad, plan.cycle.sweeps());
                Reader::Sweep(Box::new(SweepCycle::new(rules, plan.nest, temperature_channels.len())))
            }
        };
        Ok(Self {
            aligner: Aligner::new(&channels, AlignLimits::default()),
            reader,
            zero_mm: vec![None; plan.cycle.setups.len()],
            points: Vec::new(),
            gaps: Vec::new(),
            temperature_channels: temperature_channels.to_vec(),
            controller_ended_s: None,
            newest_s: 0.0,
            ended: None,
        })
    }

    fn take(
        &mut self,
        message: &Message,
        start_s: f64,
        timebase: &mut TimeBase,
        recorder: &RecordSender,
        now: HostTime,
    ) {
        let Some(timed) = timebase.translate(message) else { return };
        let aligned = match timed {
            Timed::Probe(mut sample) => {
                sample.time_s -= start_s;
                record(recorder, Item::Probes(vec![sample]), now);
                self.newest_s = self.newest_s.max(sample.time_s);
                self.aligner.push_probe(&sample)
            }
            Timed::Axes(mut sample) => {
                sample.time_s -= start_s;
                record(recorder, Item::Axes(vec![sample]), now);
                self.newest_s = self.newest_s.max(sample.time_s);
                self.aligner.push_axes(&sample)
            }
            Timed::Gap(mut gap) => {
                gap.from_s -= start_s;
                gap.to_s -= start_s;
                record(recorder, Item::Gap(gap.clone()), now);
                // What was missing before the program ran is no loss of this run.
                if gap.to_s > FIRST_MOTION_S {
                    self.gaps.push(gap);
                }
                Vec::new()
            }
            Timed::Temperature { name, degc, time_s } => {
                if let Some(channel) = self.temperature_channels.iter().position(|known| *known == name) {
                    self.reader.set_temperature(channel, degc);
                    let channel = channel as u16;
                    let item = Temperature { time_s: time_s - start_s, channel, value_degc: degc };
                    record(recorder, Item::Temperature(item), now);
                }
                Vec::new()
            }
            Timed::Event(mut event) => {
                event.time_s -= start_s;
                record(recorder, Item::Event(event), now);
                Vec::new()
            }
        };
        for step in aligned {
            let events = self.reader.push(&step);
            self.react(events, recorder, now);
        }
        if self.controller_ended_s.is_some_and(|ended_s| self.newest_s > ended_s + AFTERMATH_S) {
            self.finish(EndReason::ControllerEnded, recorder, now);
        }
    }

    /// The controller, or a long stand, shows the end; samples under way are still taken.
    fn told_end(&mut self, time_s: f64, why: String, recorder: &RecordSender, now: HostTime) {
        record(recorder, Item::Event(Event { time_s, kind: "end-seen".into(), text: why }), now);
        self.controller_ended_s = Some(time_s);
    }

    fn finish(&mut self, reason: EndReason, recorder: &RecordSender, now: HostTime) {
        if self.ended.is_some() {
            return;
        }
        for step in self.aligner.finish() {
            let events = self.reader.push(&step);
            self.react(events, recorder, now);
        }
        let events = self.reader.finish(reason, self.newest_s);
        self.react(events, recorder, now);
        if let Some(text) = self.reader.left_out() {
            let event = Event { time_s: self.newest_s, kind: "samples-left-out".into(), text };
            record(recorder, Item::Event(event), now);
        }
        self.ended.get_or_insert(reason);
    }

    fn react(&mut self, events: Vec<CycleEvent>, recorder: &RecordSender, now: HostTime) {
        for event in events {
            match event {
                CycleEvent::Point { mut point, .. } => {
                    self.zero(&mut point);
                    record(recorder, Item::Point(point.clone()), now);
                    self.points.push(point);
                }
                CycleEvent::UnknownStand { time_s, position } => {
                    let text = format!("stand at none of the poses to come: {:?}", position.0);
                    record(recorder, Item::Event(Event { time_s, kind: "unknown-stand".into(), text }), now);
                }
                CycleEvent::Ended { reason, time_s } => {
                    let text = format!("{reason:?}");
                    record(recorder, Item::Event(Event { time_s, kind: "cycle-end".into(), text }), now);
                    self.ended = Some(reason);
                }
            }
        }
    }

    fn zero(&mut self, point: &mut Point) {
        if point.quality == Quality::NoReading {
            return;
        }
        let reading_mm = Vector3::from(point.reading_mm);
        let zero_mm = *self.zero_mm[point.state.setup].get_or_insert(reading_mm);
        point.reading_mm = (reading_mm - zero_mm).into();
        point.state.deflection_mm -= zero_mm;
    }

    fn into_measured(self, plan: &Plan, name: &str) -> Measured {
        let kind = plan.cycle.run_kind();
        let run = Run {
            name: name.into(),
            machine: plan.machine.clone(),
            kind,
            setups: plan.cycle.setups.clone(),
            channels: self.temperature_channels,
            points: self.points,
        };
        Measured { run, reason: self.ended.unwrap_or(EndReason::Stopped), gaps: self.gaps }
    }
}

/// The recorder counts what it cannot take and records it as a gap itself; here nothing more can be done.
fn record(recorder: &RecordSender, item: Item, arrival: HostTime) {
    if !recorder.try_send(item, arrival) {
        tracing::debug!("the recorder is full; the loss is counted in the recording");
    }
}
