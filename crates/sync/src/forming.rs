//! Samples in run time become points: the same for a live run and for a recording whose samples are read again.
//!
//! Pure: every input carries its time.

use crate::plan::{Plan, PlanError, check};
use crate::{
    AlignLimits, Aligned, Aligner, CycleEvent, EndReason, Progress, StaticCycle, StaticRules, SweepCycle,
    SweepRules,
};
use nalgebra::Vector3;
use trunnion_core::{AxisLetter, AxisSample, Event, Point, ProbeSample, Quality};
use trunnion_cycles::cycle::Motion;

/// What came of samples.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "nearly all of them are points")]
pub enum Formed {
    /// A point, zeroed at the first good one of its setup.
    Point(Point),
    /// Something a reader of the recording should know.
    Event(Event),
}

/// A cycle on its way from samples to points.
pub struct Forming {
    aligner: Aligner,
    reader: Reader,
    /// Reading of the first good point of each setup: only changes from there are measured (S1 eq. 14).
    zero_mm: Vec<Option<Vector3<f64>>>,
    newest_s: f64,
    ended: Option<EndReason>,
}

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

impl Forming {
    /// At the start of the cycle.
    ///
    /// # Errors
    /// When the plan cannot be measured.
    pub fn new(plan: &Plan, temperature_channels: usize) -> Result<Self, PlanError> {
        let channels = check(plan)?;
        let axes: Vec<AxisLetter> = plan.machine.axes().map(|axis| axis.letter).collect();
        let calibrations = vec![plan.nest; plan.cycle.setups.len()];
        let reader = match &plan.cycle.motion {
            Motion::Static { settle, .. } | Motion::Line { settle, .. } => {
                let poses = plan.cycle.poses(&plan.machine).unwrap_or_default();
                let rules = StaticRules::new(*settle).with_wait(plan.cycle.rounds.wait_s);
                Reader::Static(Box::new(StaticCycle::new(
                    poses,
                    rules,
                    calibrations,
                    axes,
                    temperature_channels,
                )))
            }
            Motion::Path { .. } => {
                let cycle = plan.cycle.name.clone();
                return Err(PlanError::NotLive { cycle, what: "a curve of several axes".into() });
            }
            Motion::OnTheFly { axis, from_to_rad, .. } => {
                let rules = SweepRules::new(*axis, *from_to_rad, plan.cycle.sweeps());
                Reader::Sweep(Box::new(SweepCycle::new(rules, plan.nest, temperature_channels)))
            }
        };
        Ok(Self {
            aligner: Aligner::new(&channels, AlignLimits::default()),
            reader,
            zero_mm: vec![None; plan.cycle.setups.len()],
            newest_s: 0.0,
            ended: None,
        })
    }

    /// Takes a displacement.
    pub fn probe(&mut self, sample: &ProbeSample) -> Vec<Formed> {
        self.newest_s = self.newest_s.max(sample.time_s);
        let aligned = self.aligner.push_probe(sample);
        self.read(&aligned)
    }

    /// Takes axis positions.
    pub fn axes(&mut self, sample: &AxisSample) -> Vec<Formed> {
        self.newest_s = self.newest_s.max(sample.time_s);
        let aligned = self.aligner.push_axes(sample);
        self.read(&aligned)
    }

    /// Sets a temperature channel to its latest value, °C.
    pub fn temperature(&mut self, channel: usize, degc: f64) {
        self.reader.set_temperature(channel, degc);
    }

    /// Time of the newest sample, s.
    pub fn newest_s(&self) -> f64 {
        self.newest_s
    }

    /// Why the cycle is over; `None` while it is not.
    pub fn ended(&self) -> Option<EndReason> {
        self.ended
    }

    /// Points decided, passes swept.
    pub fn progress(&self) -> Progress {
        self.reader.progress()
    }

    /// Ends the cycle and gives out what was waiting.
    pub fn finish(&mut self, reason: EndReason) -> Vec<Formed> {
        if self.ended.is_some() {
            return Vec::new();
        }
        let aligned = self.aligner.finish();
        let mut formed = self.read(&aligned);
        let events = self.reader.finish(reason, self.newest_s);
        formed.extend(self.react(events));
        if let Some(text) = self.reader.left_out() {
            formed.push(Formed::Event(Event {
                time_s: self.newest_s,
                kind: "samples-left-out".into(),
                text,
            }));
        }
        self.ended.get_or_insert(reason);
        formed
    }

    fn read(&mut self, aligned: &[Aligned]) -> Vec<Formed> {
        let mut formed = Vec::new();
        for step in aligned {
            let events = self.reader.push(step);
            formed.extend(self.react(events));
        }
        formed
    }

    fn react(&mut self, events: Vec<CycleEvent>) -> Vec<Formed> {
        let mut formed = Vec::new();
        for event in events {
            formed.push(match event {
                CycleEvent::Point { mut point, .. } => {
                    self.zero(&mut point);
                    Formed::Point(point)
                }
                CycleEvent::UnknownStand { time_s, position } => {
                    let text = format!("stand at none of the poses to come: {:?}", position.0);
                    Formed::Event(Event { time_s, kind: "unknown-stand".into(), text })
                }
                CycleEvent::Ended { reason, time_s } => {
                    self.ended = Some(reason);
                    Formed::Event(Event { time_s, kind: "cycle-end".into(), text: format!("{reason:?}") })
                }
            });
        }
        formed
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
}
