//! The cycle on the fly: one rotary axis turns at constant feed while the probes are read.
//!
//! A sample counts while the named axis turns at one of the feeds of the cycle (within a tolerance) and its
//! acceleration is below the limit; the position in a point is the actual one. Blocks of samples are averaged down to a
//! target rate; a block never crosses a change of direction or feed, a missing value, or a hole. The passes of the cycle
//! (setups, feeds, directions, rounds) are followed in their order; what belongs to none is left out and counted. Pure,
//! like the static cycle.

mod passes;

use crate::align::Aligned;
use crate::align::AxisState;
use crate::cycle_event::Progress;
use crate::nest::NestCalibration;
use nalgebra::Vector3;
use passes::Passes;
use trunnion_core::{AxisValues, Joint, Point, Quality};
use trunnion_cycles::cycle::Sweep;

/// Rules of a cycle on the fly.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRules {
    /// The turning axis.
    pub axis: Joint,
    /// First and last angle, rad; samples outside are the run-in and are left out.
    pub from_to_rad: (f64, f64),
    /// The passes of the cycle in order ([`trunnion_cycles::Cycle::sweeps`]).
    pub passes: Vec<Sweep>,
    /// Largest difference of the velocity from a feed, as a fraction of it.
    pub feed_tolerance: f64,
    /// Largest acceleration that counts as constant feed, rad/s².
    pub acceleration_limit: f64,
    /// Points a second after averaging; 0 keeps every sample.
    pub points_per_s: f64,
    /// Longest distance of two samples in one block, s.
    pub sample_gap_s: f64,
}

impl SweepRules {
    /// Usual rules for an axis, its span and its passes.
    pub fn new(axis: Joint, from_to_rad: (f64, f64), passes: Vec<Sweep>) -> Self {
        let slowest = passes.iter().map(|pass| pass.feed_rad_per_s.abs()).fold(f64::INFINITY, f64::min);
        Self {
            axis,
            from_to_rad,
            passes,
            feed_tolerance: 0.05,
            acceleration_limit: if slowest.is_finite() { slowest } else { 1.0 },
            points_per_s: 100.0,
            sample_gap_s: 0.05,
        }
    }

    /// The signed feed at which a sample was taken, if it counts.
    fn feed_of(&self, sample: &AxisState) -> Option<f64> {
        let velocity = sample.velocity[self.axis];
        let (low, high) =
            (self.from_to_rad.0.min(self.from_to_rad.1), self.from_to_rad.0.max(self.from_to_rad.1));
        let inside = (low..=high).contains(&sample.position[self.axis]);
        let steady = sample.acceleration[self.axis].abs() <= self.acceleration_limit;
        let is_at = |feed: &f64| (velocity - feed).abs() <= self.feed_tolerance * feed.abs();
        let feed = self.passes.iter().map(|pass| pass.feed_rad_per_s).find(is_at)?;
        (inside && steady).then_some(feed)
    }
}

/// The state machine.
#[derive(Clone, Debug)]
pub struct SweepCycle {
    rules: SweepRules,
    calibration: NestCalibration,
    temperature_degc: Vec<f64>,
    block: Vec<(AxisState, [f64; 3])>,
    block_pass: usize,
    passes: Passes,
    incomplete: u64,
}

impl SweepCycle {
    /// At the start of the cycle.
    pub fn new(rules: SweepRules, calibration: NestCalibration, temperature_channels: usize) -> Self {
        Self {
            passes: Passes::new(rules.passes.clone(), rules.from_to_rad),
            rules,
            calibration,
            temperature_degc: vec![f64::NAN; temperature_channels],
            block: Vec::new(),
            block_pass: 0,
            incomplete: 0,
        }
    }

    /// Sets a temperature channel to its latest value, °C; channels not announced are ignored.
    pub fn set_temperature(&mut self, channel: usize, degc: f64) {
        if let Some(value) = self.temperature_degc.get_mut(channel) {
            *value = degc;
        }
    }

    /// Takes the next step of the alignment; gives at most one point.
    pub fn push(&mut self, step: &Aligned) -> Option<Point> {
        let (sample, channels_mm) = (&step.state, step.channels_mm?);
        let place = self.rules.feed_of(sample).map(|feed| (feed, sample.position[self.rules.axis]));
        let pass = place.and_then(|(feed, angle)| self.passes.take(feed, angle));
        let Some(pass) = pass else { return self.finish() };
        if channels_mm.iter().any(|mm| mm.is_nan()) {
            self.incomplete += 1;
            return self.finish();
        }
        let joins = self.block.last().is_some_and(|(last, _)| {
            pass == self.block_pass && sample.time_s - last.time_s <= self.rules.sample_gap_s
        });
        let due = self.rules.points_per_s <= 0.0
            || self.block.first().is_some_and(|(first, _)| {
                (sample.time_s - first.time_s) * self.rules.points_per_s >= 1.0 - 1e-6
            });
        let point = if joins && !due { None } else { self.finish() };
        self.block_pass = pass;
        self.block.push((*sample, channels_mm));
        point
    }

    /// The point of the block not yet complete, if any. Call at the end.
    pub fn finish(&mut self) -> Option<Point> {
        let point = (!self.block.is_empty()).then(|| self.point(&self.block));
        self.block.clear();
        point
    }

    /// Samples left out because a channel had no value.
    pub fn incomplete(&self) -> u64 {
        self.incomplete
    }

    /// Samples left out because they belong to no pass of the cycle that was still to come.
    pub fn unplanned(&self) -> u64 {
        self.passes.unplanned()
    }

    /// Passes swept.
    pub fn progress(&self) -> Progress {
        self.passes.progress()
    }

    fn point(&self, block: &[(AxisState, [f64; 3])]) -> Point {
        let n = block.len() as f64;
        let mean =
            |value: &dyn Fn(&AxisState) -> f64| block.iter().map(|(state, _)| value(state)).sum::<f64>() / n;
        let axes = |values: fn(&AxisState) -> &AxisValues<f64>| {
            AxisValues::from_fn(|letter| mean(&|sample| values(sample)[letter]))
        };
        let readings: Vec<Vector3<f64>> =
            block.iter().map(|(_, channels_mm)| self.calibration.reading_mm(*channels_mm)).collect();
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
        point.state.position = axes(|sample| &sample.position);
        point.state.direction = block[block.len() / 2].0.direction;
        point.state.velocity = axes(|sample| &sample.velocity);
        point.state.acceleration = axes(|sample| &sample.acceleration);
        point.state.since_reversal = axes(|sample| &sample.since_reversal);
        point.state.time_s = Some(mean(&|sample| sample.time_s));
        point.state.temperature_degc = self.temperature_degc.clone();
        point.state.setup = self.rules.passes[self.block_pass].setup;
        point.state.deflection_mm = reading;
        point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forward and back at two feeds, 1 kHz, ramps of 0.1 s; the probe reads the angle.
    fn run() -> Vec<Aligned> {
        let (mut steps, mut time_s, mut angle) = (Vec::new(), 0.0, -0.1);
        for velocity in [0.5, -0.5, 1.0, -1.0f64] {
            let mut speed = 0.0f64;
            let stop = |angle: f64| if velocity > 0.0 { angle > 2.1 } else { angle < -0.1 };
            while !stop(angle) {
                let acceleration = if speed.abs() < velocity.abs() { velocity / 0.1 } else { 0.0 };
                speed += acceleration * 1e-3;
                angle += speed * 1e-3;
                time_s += 1e-3;
                let axis = |value: f64| {
                    let mut values = AxisValues::default();
                    values[Joint::C] = value;
                    values
                };
                let state = AxisState {
                    time_s,
                    position: axis(angle),
                    velocity: axis(speed),
                    acceleration: axis(acceleration),
                    direction: axis(velocity.signum()),
                    since_reversal: axis(0.0),
                };
                steps.push(Aligned { state, channels_mm: Some([angle, 0.0, 1.0]) });
            }
        }
        steps
    }

    fn sweep() -> SweepCycle {
        let pass = |feed_rad_per_s| Sweep { setup: 0, feed_rad_per_s };
        let rules = SweepRules::new(Joint::C, (0.0, 2.0), [0.5, -0.5, 1.0, -1.0].map(pass).to_vec());
        SweepCycle::new(rules, NestCalibration::orthogonal(), 0)
    }

    #[test]
    fn every_pass_gives_points_at_the_target_rate_with_angle_and_reading_of_one_instant() {
        let mut cycle = sweep();
        let mut points: Vec<Point> = run().iter().filter_map(|step| cycle.push(step)).collect();
        points.extend(cycle.finish());
        // 2 rad at 0.5 and 1 rad/s, both ways, 100 points a second
        assert!((1190..1210).contains(&points.len()), "{}", points.len());
        for point in &points {
            let angle = point.state.position[Joint::C];
            assert!((0.0..=2.0).contains(&angle));
            assert!((point.reading_mm[0] - angle).abs() < 1e-12 && point.samples <= 10);
            let velocity = point.state.velocity[Joint::C];
            assert_eq!(velocity.signum(), point.state.direction[Joint::C]);
        }
        assert_eq!((cycle.progress().done, cycle.progress().total), (4, 4));
        assert!(cycle.progress().seconds_left.unwrap() < 0.2);
    }

    #[test]
    fn a_missing_value_breaks_the_block_and_is_counted() {
        let mut steps = run();
        steps[1000].channels_mm.as_mut().unwrap()[2] = f64::NAN;
        let mut cycle = sweep();
        let points: Vec<Point> = steps.iter().filter_map(|step| cycle.push(step)).collect();
        assert_eq!(cycle.incomplete(), 1);
        assert!(points.iter().all(|point| point.reading_mm[2] == 1.0));
    }
}
