//! Samples in run time become points: the same for a live run and for a recording whose samples are read again.
//!
//! Pure: every input carries its time.

use crate::plan::{Plan, PlanError, check};
use crate::{
    AlignLimits, Aligned, Aligner, Course, CycleEvent, EndReason, Progress, SampleCounts, StaticCycle,
    StaticRules, SweepCycle, SweepRules,
};
use nalgebra::Vector3;
use trunnion_core::{AxisSample, Joint, Point, ProbeSample, Quality};
use trunnion_cycles::cycle::Motion;

/// A cycle on its way from samples to points.
pub struct Forming {
    aligner: Aligner,
    /// What the aligner gave, until it is read.
    steps: Vec<Aligned>,
    reader: Reader,
    /// Reading of the first good point of each setup: only changes from there are measured (S1 eq. 14); none are taken off a
    /// calibrated length.
    zero_mm: Vec<Option<Vector3<f64>>>,
    newest_s: f64,
    ended: Option<EndReason>,
}

enum Reader {
    Static(Box<StaticCycle>),
    /// With the points that it gave, until they are read.
    Sweep(Box<SweepCycle>, Vec<Point>),
}

impl Reader {
    fn push(&mut self, step: &Aligned, out: &mut Vec<CycleEvent>) {
        match self {
            Self::Static(cycle) => cycle.push(step, out),
            Self::Sweep(cycle, points) => {
                cycle.push(step, points);
                out.extend(points.drain(..).map(sweep_event));
            }
        }
    }

    fn finish(&mut self, reason: EndReason, time_s: f64, out: &mut Vec<CycleEvent>) {
        match self {
            Self::Static(cycle) => cycle.finish(reason, time_s, out),
            Self::Sweep(cycle, points) => {
                cycle.finish(points);
                out.extend(points.drain(..).map(sweep_event));
                out.push(CycleEvent::Ended { reason, time_s });
            }
        }
    }

    fn set_temperature(&mut self, channel: usize, degc: f64) {
        match self {
            Self::Static(cycle) => cycle.set_temperature(channel, degc),
            Self::Sweep(cycle, _) => cycle.set_temperature(channel, degc),
        }
    }

    /// What became of the samples of a cycle on the fly.
    fn counts(&self) -> Option<SampleCounts> {
        match self {
            Self::Static(_) => None,
            Self::Sweep(cycle, _) => Some(*cycle.counts()),
        }
    }

    fn progress(&self) -> Progress {
        match self {
            Self::Static(cycle) => cycle.progress(),
            Self::Sweep(cycle, _) => cycle.progress(),
        }
    }
}

/// The points of a sweep belong to no pose of a list.
fn sweep_event(point: Point) -> CycleEvent {
    let time_s = point.state.time_s.unwrap_or(0.0);
    CycleEvent::Point { pose: 0, point, time_s }
}

impl Forming {
    /// At the start of the cycle.
    ///
    /// # Errors
    /// When the plan cannot be measured.
    pub fn new(plan: &Plan, temperature_channels: usize) -> Result<Self, PlanError> {
        let channels = check(plan)?;
        let axes: Vec<Joint> = plan.machine.axes().map(|axis| axis.letter).collect();
        let calibrations = vec![plan.calibration(); plan.cycle.setups.len()];
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
            Motion::OnTheFly { .. } | Motion::Path { .. } => {
                let not_live = || PlanError::NotLive {
                    cycle: plan.cycle.name.clone(),
                    what: "a motion that is not on the fly".into(),
                };
                let course = Course::of(&plan.machine, &plan.cycle).ok_or_else(not_live)?;
                let rules = SweepRules::of(&plan.cycle).ok_or_else(not_live)?;
                let cycle = SweepCycle::new(rules, course, plan.calibration(), temperature_channels);
                Reader::Sweep(Box::new(cycle), Vec::new())
            }
        };
        Ok(Self {
            aligner: Aligner::new(&channels, AlignLimits::default()),
            steps: Vec::new(),
            reader,
            zero_mm: plan.cycle.setups.iter().map(|s| s.calibrated.then(Vector3::zeros)).collect(),
            newest_s: 0.0,
            ended: None,
        })
    }

    /// Takes a displacement. What came of it goes to the end of `out`: points are zeroed at the first good one of their
    /// setup.
    pub fn probe(&mut self, sample: &ProbeSample, out: &mut Vec<CycleEvent>) {
        self.newest_s = self.newest_s.max(sample.time_s);
        self.aligner.push_probe(sample, &mut self.steps);
        self.read(out);
    }

    /// Takes axis positions, as [`Forming::probe`] takes a displacement.
    pub fn axes(&mut self, sample: &AxisSample, out: &mut Vec<CycleEvent>) {
        self.newest_s = self.newest_s.max(sample.time_s);
        self.aligner.push_axes(sample, &mut self.steps);
        self.read(out);
    }

    /// Sets a temperature channel to its latest value, °C.
    pub fn temperature(&mut self, channel: usize, degc: f64) {
        self.reader.set_temperature(channel, degc);
    }

    /// The program waits for a person, or goes on.
    pub fn set_held(&mut self, held: bool) {
        if let Reader::Static(cycle) = &mut self.reader {
            cycle.set_held(held);
        }
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
    pub fn finish(&mut self, reason: EndReason, out: &mut Vec<CycleEvent>) {
        if self.ended.is_some() {
            return;
        }
        self.aligner.finish(&mut self.steps);
        self.read(out);
        let from = out.len();
        self.reader.finish(reason, self.newest_s, out);
        self.note(&mut out[from..]);
        let time_s = self.newest_s;
        out.extend(self.reader.counts().map(|counts| CycleEvent::Samples { time_s, counts }));
        self.ended.get_or_insert(reason);
    }

    /// Reads what the aligner gave.
    fn read(&mut self, out: &mut Vec<CycleEvent>) {
        let from = out.len();
        for step in self.steps.drain(..) {
            self.reader.push(&step, out);
        }
        self.note(&mut out[from..]);
    }

    /// Zeroes the points, and notes the end.
    fn note(&mut self, events: &mut [CycleEvent]) {
        for event in events {
            match event {
                CycleEvent::Point { point, .. } => self.zero(point),
                CycleEvent::Ended { reason, .. } => self.ended = Some(*reason),
                CycleEvent::UnknownDwell { .. } | CycleEvent::Samples { .. } => {}
            }
        }
    }

    fn zero(&mut self, point: &mut Point) {
        if matches!(point.quality, Quality::NoReading(_)) {
            return;
        }
        let reading_mm = Vector3::from(point.reading_mm);
        let zero_mm = *self.zero_mm[point.state.setup].get_or_insert(reading_mm);
        point.reading_mm = (reading_mm - zero_mm).into();
        point.state.deflection_mm -= zero_mm;
    }
}
