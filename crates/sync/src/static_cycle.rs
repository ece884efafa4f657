//! The static cycle: a point is read when all axes stand at the next pose and the reading has settled.
//!
//! Pure: all inputs carry their times, so a recording gives the same points as the live run. A point is *good* when,
//! over one window, the axes stood, every channel had samples throughout, its halves agree within the drift limit and
//! its robust spread (1.4826 · median absolute deviation) is within the noise limit. A pose that was left early or never
//! settled is marked `Unsettled` with what was read; one that was passed by, or without a probe value, `NoReading` with
//! NaN and what it lacks. Every pose gives exactly one point.
//!
//! Two poses at one place one after the other (the grid turns back) may be one dwell: the second is read from a window
//! of its own behind the first. Should the machine leave and come back to it, the later reading counts.

mod dwell;
mod dwells;
mod rules;

pub use dwells::{DwellReader, DwellReading};
pub use rules::{StandsAt, StaticRules};

use crate::align::{Aligned, AxisState};
use crate::cycle_event::{CycleEvent, EndReason, Progress};
use crate::nest::NestCalibration;
use dwell::Dwell;
use trunnion_core::{AxisValues, Joint, Lacks, Point, Quality};
use trunnion_cycles::cycle::Pose;

/// The state machine.
#[derive(Clone, Debug)]
pub struct StaticCycle {
    rules: StaticRules,
    poses: Vec<Pose>,
    /// By setup.
    calibrations: Vec<NestCalibration>,
    /// Axes of the machine.
    axes: Vec<Joint>,
    temperature_degc: Vec<f64>,
    next: usize,
    dwell: Dwell,
    /// Reading of pose `next` taken in the dwell of the pose before it.
    early: Option<Point>,
    /// A point was decided in this dwell, and the machine has not left since.
    served: bool,
    reported_unknown: bool,
    pace: Option<(f64, usize, f64)>,
    /// The program waits for a person; until when it was last seen to, s.
    held: bool,
    held_until_s: f64,
    ended: bool,
}

impl StaticCycle {
    /// For poses in order ([`trunnion_cycles::Cycle::poses`]), one calibration for each setup (the last stands
    /// for those missing; none means orthogonal probes), and the axes the controller reports.
    pub fn new(
        poses: Vec<Pose>,
        rules: StaticRules,
        calibrations: Vec<NestCalibration>,
        axes: Vec<Joint>,
        temperature_channels: usize,
    ) -> Self {
        Self {
            dwell: Dwell::new(&rules),
            rules,
            poses,
            calibrations,
            axes,
            temperature_degc: vec![f64::NAN; temperature_channels],
            next: 0,
            early: None,
            served: false,
            reported_unknown: false,
            pace: None,
            held: false,
            held_until_s: f64::NEG_INFINITY,
            ended: false,
        }
    }

    /// Sets a temperature channel to its latest value, °C; channels not announced are ignored.
    pub fn set_temperature(&mut self, channel: usize, degc: f64) {
        if let Some(value) = self.temperature_degc.get_mut(channel) {
            *value = degc;
        }
    }

    /// The program waits for a person, or goes on: standing in a hold is not the end of the cycle, however long.
    pub fn set_held(&mut self, held: bool) {
        self.held = held;
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        let seconds_left = self.pace.and_then(|(first_s, first, last_s)| {
            let (steps, left) = (self.next.checked_sub(first + 1)?, self.poses.len() - self.next);
            (steps > 0).then(|| (last_s - first_s) / steps as f64 * left as f64)
        });
        Progress { done: self.next, total: self.poses.len(), seconds_left }
    }

    /// Takes the next step of the alignment; steps come in order of time. What happened goes to the end of `events`.
    pub fn push(&mut self, step: &Aligned, events: &mut Vec<CycleEvent>) {
        match step.channels_mm {
            _ if self.ended => {}
            Some(channels_mm) => self.dwell.push_sample(step.state.time_s, channels_mm),
            None => self.push_axes(&step.state, events),
        }
    }

    /// Ends the cycle from outside; the poses left get points without reading.
    pub fn finish(&mut self, reason: EndReason, time_s: f64, events: &mut Vec<CycleEvent>) {
        if !self.ended {
            self.leave(time_s, events);
        }
        if !self.ended {
            self.end(reason, time_s, events);
        }
    }

    fn push_axes(&mut self, state: &AxisState, events: &mut Vec<CycleEvent>) {
        if self.dwell.is_left_by(state, &self.axes) {
            self.leave(state.time_s, events);
        }
        self.dwell.push_axes(state, &self.axes);
        if self.ended || !self.dwell.is_stationary() {
            return;
        }
        if self.served {
            self.read_early(state, events);
        } else {
            self.read(state, events);
        }
        if self.held {
            self.held_until_s = state.time_s;
        }
        let still_s = state.time_s - self.dwell.began_s().max(self.held_until_s);
        if !self.ended && still_s > self.rules.end_after_still_s && !self.awaits_a_person() {
            self.end(EndReason::NoMotion, state.time_s, events);
        }
    }

    /// Finds the pose the machine stands at and decides its point when it is time.
    fn read(&mut self, state: &AxisState, events: &mut Vec<CycleEvent>) {
        let timed_out = state.time_s - self.dwell.began_s() >= self.dwell.timeout_s();
        let Some(ahead) = self.find_pose(&state.position) else {
            if !std::mem::replace(&mut self.reported_unknown, true) {
                let time_s = self.dwell.began_s();
                events.push(CycleEvent::UnknownDwell { time_s, position: state.position });
            }
            return;
        };
        let quality = match self.dwell.is_settled() {
            true => Quality::Good,
            false if timed_out => Quality::Unsettled,
            false => return,
        };
        self.skip(ahead, state.time_s, events);
        let fresh = self.point(self.next, quality);
        let early = self.early.take().filter(|_| quality != Quality::Good);
        self.served = true;
        self.dwell.mark_read();
        self.decide(early.unwrap_or(fresh), state.time_s, events);
    }

    /// How many poses ahead of the next one the machine stands. Coming back to a pose just read is no jump to the
    /// pose at the same place in a later pass.
    fn find_pose(&self, position: &AxisValues<f64>) -> Option<usize> {
        let near = |pose: &Pose| self.rules.is_near(position, pose, &self.axes);
        let ahead = self.poses[self.next..].iter().position(near)?;
        let just_read = self.next.checked_sub(1).map(|last| &self.poses[last]);
        (ahead == 0 || !just_read.is_some_and(near)).then_some(ahead)
    }

    /// The next pose may be where the machine stands already: it gets a window of its own.
    fn read_early(&mut self, state: &AxisState, events: &mut Vec<CycleEvent>) {
        let Some(pose) = self.poses.get(self.next).filter(|_| self.early.is_none()) else { return };
        if !self.rules.is_near(&state.position, pose, &self.axes) || !self.dwell.is_settled() {
            return;
        }
        let point = self.point(self.next, Quality::Good);
        if self.next + 1 < self.poses.len() {
            self.early = Some(point);
        } else {
            self.decide(point, state.time_s, events); // no later dwell could show more
        }
    }

    /// The machine leaves: a pose stood at but not read is marked.
    fn leave(&mut self, time_s: f64, events: &mut Vec<CycleEvent>) {
        let here = self.dwell.latest().filter(|_| self.dwell.is_stationary() && !self.served).copied();
        if let (Some(state), Some(pose)) = (here, self.poses.get(self.next))
            && self.early.is_none()
            && self.rules.is_near(&state.position, pose, &self.axes)
        {
            let point = self.point(self.next, Quality::Unsettled);
            self.decide(point, time_s, events);
        }
        self.served = false;
        self.reported_unknown = false;
        self.dwell = self.dwell.next();
    }

    /// Between two setups a person mounts the nest again; that may take long.
    fn awaits_a_person(&self) -> bool {
        let setup = |index: usize| self.poses.get(index).map(|pose| pose.setup);
        self.next > 0 && setup(self.next) != setup(self.next - 1)
    }

    /// Points for the poses passed by before the one `ahead` of the next.
    fn skip(&mut self, ahead: usize, time_s: f64, events: &mut Vec<CycleEvent>) {
        for _ in 0..ahead {
            let point = self.early.take().unwrap_or_else(|| self.missing(self.next, Lacks::Dwell));
            self.decide(point, time_s, events);
        }
    }

    fn decide(&mut self, point: Point, time_s: f64, events: &mut Vec<CycleEvent>) {
        events.push(CycleEvent::Point { pose: self.next, point, time_s });
        let (first_s, first, _) = self.pace.unwrap_or((time_s, self.next, time_s));
        self.pace = Some((first_s, first, time_s));
        self.next += 1;
        if self.next == self.poses.len() {
            self.ended = true;
            events.push(CycleEvent::Ended { reason: EndReason::Complete, time_s });
        }
    }

    fn end(&mut self, reason: EndReason, time_s: f64, events: &mut Vec<CycleEvent>) {
        while self.next < self.poses.len() {
            let point = self.early.take().unwrap_or_else(|| self.missing(self.next, Lacks::End));
            events.push(CycleEvent::Point { pose: self.next, point, time_s });
            self.next += 1;
        }
        self.ended = true;
        events.push(CycleEvent::Ended { reason, time_s });
    }

    /// The point of a pose from the window of this dwell.
    fn point(&self, index: usize, quality: Quality) -> Point {
        let mut point = self.missing(index, Lacks::Value);
        let calibration =
            self.calibrations.get(self.poses[index].setup).or(self.calibrations.last()).copied();
        let calibration = calibration.unwrap_or_else(NestCalibration::orthogonal);
        let Some(summary) = self.dwell.summary(&calibration) else { return point };
        let (direction, since_reversal) = self.dwell.approach();
        point.state.direction = direction;
        point.state.since_reversal = since_reversal;
        point.state.time_s = Some(summary.time_s);
        point.state.deflection_mm = summary.reading_mm.into();
        point.reading_mm = summary.reading_mm;
        point.spread_mm = summary.spread_mm;
        point.samples = summary.samples;
        point.quality = quality;
        point
    }

    /// The point of a pose without a reading: NaN, with the direction the cycle asked for.
    fn missing(&self, index: usize, lacks: Lacks) -> Point {
        let pose = &self.poses[index];
        let mut point = Point {
            state: Default::default(),
            reading_mm: [f64::NAN; 3],
            spread_mm: [f64::NAN; 3],
            samples: 0,
            quality: Quality::NoReading(lacks),
        };
        point.state.position = pose.position;
        point.state.direction = pose.direction;
        point.state.setup = pose.setup;
        point.state.temperature_degc = self.temperature_degc.clone();
        point
    }
}

#[cfg(test)]
mod tests;
