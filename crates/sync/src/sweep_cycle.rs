//! The cycle on the fly: one rotary axis turns at constant feed, or a curve is travelled, while the probes are read.
//!
//! A sample counts while the angle along the course changes at one of the feeds of the cycle and its acceleration is below the
//! limit, both as far as the jitter of the stamps lets them be known (`pace`). Samples are averaged down to a target
//! rate; an average never crosses a change of direction or feed, a missing value, or a hole. Readings and positions are averaged in one
//! frame, as departures from the course (`course`). The passes of the cycle (setups, feeds, directions, rounds) are followed in
//! their order. Every sample of a pass that was taken inside the span counts as used or excluded, with the
//! reason; those on the way to a pass do not. Pure, like the static cycle.

mod counts;
mod course;
mod feed;
mod pace;
mod passes;
mod rules;
mod stretch;

pub use counts::SampleCounts;
pub use course::Course;
pub use feed::at_feed;
pub use rules::SweepRules;

use crate::align::{Aligned, AxisState};
use crate::blocks::UNIT;
use crate::cycle_event::Progress;
use crate::interval::Interval;
use crate::nest::NestCalibration;
use course::nearest_turn;
use nalgebra::Vector3;
use pace::Pace;
use passes::Passes;
use rules::GOES_ON_RAD;
use std::collections::VecDeque;
use stretch::Stretch;
use trunnion_core::{AxisValues, Joint, Point, Quality};

/// Longest travel that is averaged, in units of blocks (1°): 60 waves a turn lose 1 % by it.
const LONGEST_UNITS: f64 = 0.5;

/// The state machine.
#[derive(Clone, Debug)]
pub struct SweepCycle {
    rules: SweepRules,
    course: Course,
    calibration: NestCalibration,
    temperature_degc: Vec<f64>,
    pace: Pace,
    /// How often the probes are read.
    interval: Interval,
    /// Samples whose surroundings are not yet known; the alignment gives none without a position after it.
    waiting: VecDeque<(AxisState, [f64; 3])>,
    block: Vec<Sample>,
    block_pass: usize,
    passes: Passes,
    counts: SampleCounts,
    stretch: Stretch,
    /// On a curve: turns added to the angle, and feed, angle and time of the last sample at a feed.
    turns_rad: f64,
    last_at_feed: Option<(f64, f64, f64)>,
}

/// A sample that counts.
#[derive(Clone, Debug)]
struct Sample {
    state: AxisState,
    angle: f64,
    departure: Option<AxisValues<f64>>,
    channels_mm: [f64; 3],
}

impl SweepCycle {
    /// At the start of the cycle.
    pub fn new(
        rules: SweepRules,
        course: Course,
        calibration: NestCalibration,
        temperature_channels: usize,
    ) -> Self {
        Self {
            passes: Passes::new(rules.passes.clone(), rules.from_to_rad),
            rules,
            course,
            calibration,
            temperature_degc: vec![f64::NAN; temperature_channels],
            pace: Pace::default(),
            interval: Interval::default(),
            waiting: VecDeque::new(),
            block: Vec::new(),
            block_pass: 0,
            counts: SampleCounts::default(),
            stretch: Stretch::default(),
            turns_rad: 0.0,
            last_at_feed: None,
        }
    }

    /// Sets a temperature channel to its latest value, °C; channels not announced are ignored.
    pub fn set_temperature(&mut self, channel: usize, degc: f64) {
        if let Some(value) = self.temperature_degc.get_mut(channel) {
            *value = degc;
        }
    }

    /// Takes the next step of the alignment. Points go to the end of `out`, once what follows them is known.
    pub fn push(&mut self, step: &Aligned, out: &mut Vec<Point>) {
        match step.channels_mm {
            Some(channels_mm) => self.waiting.push_back((step.state, channels_mm)),
            None => {
                let angle = self.course.angle(&step.state.position, self.pace.last_angle());
                self.pace.push(&step.state, angle);
                // Steps come in order of time: without samples nothing older is asked for.
                if self.waiting.is_empty() {
                    self.pace.forget_before(step.state.time_s);
                }
            }
        }
        while let Some((state, channels_mm)) =
            self.waiting.pop_front_if(|(state, _)| self.pace.is_known_around(state.time_s))
        {
            out.extend(self.take(state, channels_mm));
        }
    }

    /// What was waiting, and the point not yet complete. Call at the end.
    pub fn finish(&mut self, out: &mut Vec<Point>) {
        for (state, channels_mm) in std::mem::take(&mut self.waiting) {
            out.extend(self.take(state, channels_mm));
        }
        self.counts.other_speed += self.stretch.end(&self.rules);
        out.extend(self.close());
    }

    /// Samples used and excluded so far.
    pub fn counts(&self) -> &SampleCounts {
        &self.counts
    }

    /// Passes swept.
    pub fn progress(&self) -> Progress {
        self.passes.progress()
    }

    /// The next sample; the point that it closes.
    fn take(&mut self, mut state: AxisState, channels_mm: [f64; 3]) -> Option<Point> {
        self.interval.push(state.time_s);
        self.pace.forget_before(state.time_s);
        let Some(motion) = self.pace.motion(state.time_s) else { return self.close() };
        (state.velocity, state.acceleration) = (motion.velocity, motion.acceleration);
        let angle = motion.angle;
        let feed = self.rules.feed_of(&motion);
        let way = if self.rules.is_asked(&motion) { motion.pace.0.signum() } else { 0.0 };
        let here = angle + self.turns_rad;
        self.counts.other_speed += self.stretch.take(&self.rules, (way, here), feed.is_some());
        let Some(feed) = feed else { return self.close() };
        let angle = self.on_course(feed, angle, state.time_s);
        if !self.rules.holds(angle) {
            return self.close();
        }
        let Some(pass) = self.passes.take(feed, angle) else {
            self.counts.unplanned += 1;
            return self.close();
        };
        if channels_mm.iter().any(|mm| mm.is_nan()) {
            self.counts.incomplete += 1;
            return self.close();
        }
        self.counts.take(&motion);
        let departure = self.departure(self.rules.passes[pass].setup, &state);
        let sample = Sample { state, angle, departure, channels_mm };
        let point = if self.joins(pass, &sample) { None } else { self.close() };
        self.block_pass = pass;
        self.block.push(sample);
        point
    }

    /// On a curve: the angle with its turns, which a new pass takes from where it begins. Behind the end of a pass only a stop
    /// separates the run-out from the beginning of another.
    fn on_course(&mut self, feed: f64, angle: f64, time_s: f64) -> f64 {
        if self.course.is_modulo() {
            let here = angle + self.turns_rad;
            let (low, high) = self.rules.span();
            let (begin, end) = if feed > 0.0 { (low, high) } else { (high, low) };
            let longest_s = self.interval.longest_gap_s(self.rules.sample_gap_s);
            let goes_on = self.last_at_feed.is_some_and(|(last_feed, last, last_s)| {
                last_feed == feed
                    && (here - last).abs() < GOES_ON_RAD
                    && ((end - last).abs() > GOES_ON_RAD || time_s - last_s <= longest_s)
            });
            if !goes_on {
                self.turns_rad = nearest_turn(angle, begin) - angle;
            }
            self.last_at_feed = Some((feed, angle + self.turns_rad, time_s));
        }
        angle + self.turns_rad
    }

    /// Departure from the course, between those of the positions recorded before and after.
    fn departure(&mut self, setup: usize, state: &AxisState) -> Option<AxisValues<f64>> {
        let course = &self.course;
        let ([before, after], share) = self.pace.around(state.time_s)?;
        let [before, after] = [before, after].map(|node| match node.departure {
            Some((of, departure)) if of == setup => departure,
            _ => {
                let departure = course.departure(setup, node.angle, &node.position);
                node.departure = Some((setup, departure));
                departure
            }
        });
        let (before, after) = before.zip(after)?;
        Some(AxisValues::from_fn(|slot| before[slot] + share * (after[slot] - before[slot])))
    }

    /// True when a sample belongs to the point under way.
    fn joins(&self, pass: usize, sample: &Sample) -> bool {
        let Some((first, last)) = self.block.first().zip(self.block.last()) else { return true };
        let apart_s = sample.state.time_s - last.state.time_s;
        let since_s = sample.state.time_s - first.state.time_s;
        let travel_rad = (sample.angle - first.angle).abs();
        pass == self.block_pass
            && apart_s <= self.interval.longest_gap_s(self.rules.sample_gap_s)
            && since_s * self.rules.points_per_s < 1.0 - 1e-6
            && self.rules.points_per_s > 0.0
            && travel_rad < LONGEST_UNITS * UNIT[Joint::C]
    }

    fn close(&mut self) -> Option<Point> {
        let point = (!self.block.is_empty()).then(|| self.point(&self.block));
        self.block.clear();
        point
    }

    fn point(&self, block: &[Sample]) -> Point {
        let n = block.len() as f64;
        let mean = |value: &dyn Fn(&Sample) -> f64| block.iter().map(value).sum::<f64>() / n;
        let axes = |values: fn(&AxisState) -> &AxisValues<f64>| {
            AxisValues::from_fn(|slot| mean(&|sample| values(&sample.state)[slot]))
        };
        let setup = self.rules.passes[self.block_pass].setup;
        let readings: Vec<Vector3<f64>> =
            block.iter().map(|sample| self.calibration.reading_mm(sample.channels_mm)).collect();
        let reading = readings.iter().sum::<Vector3<f64>>() / n;
        let square = |r: &Vector3<f64>| (r - reading).component_mul(&(r - reading));
        let spread = (readings.iter().map(square).sum::<Vector3<f64>>() / (n - 1.0).max(1.0)).map(f64::sqrt);
        let mut point = Point {
            state: Default::default(),
            reading_mm: reading.into(),
            spread_mm: spread.into(),
            samples: block.len() as u32,
            quality: Quality::Good,
        };
        let as_read = axes(|state| &state.position);
        let on_course = self.course.position(setup, mean(&|sample| sample.angle), &as_read);
        let departures: Option<Vec<AxisValues<f64>>> = block.iter().map(|sample| sample.departure).collect();
        // A machine that cannot follow the course has nothing to depart from.
        point.state.position = on_course.zip(departures).map_or(as_read, |(on_course, departures)| {
            let departure = |slot| departures.iter().map(|departure| departure[slot]).sum::<f64>() / n;
            AxisValues::from_fn(|slot| on_course[slot] + departure(slot))
        });
        point.state.direction = block[block.len() / 2].state.direction;
        point.state.velocity = axes(|state| &state.velocity);
        point.state.acceleration = axes(|state| &state.acceleration);
        point.state.since_reversal = axes(|state| &state.since_reversal);
        point.state.time_s = Some(mean(&|sample| sample.state.time_s));
        point.state.temperature_degc = self.temperature_degc.clone();
        point.state.setup = setup;
        point.state.deflection_mm = reading;
        point
    }
}

#[cfg(test)]
mod tests;
