//! The sums of one block; two neighbouring blocks add up to one exactly.
//!
//! Means are kept as means (m ← m + (x − m)/n, blocks: m ← m₁ + (m₂ − m₁) n₂/n), so that what is constant stays bit for bit
//! what it was; second moments are about the mean (Chan, Golub, LeVeque 1983).

use super::spectrum::Noise;
use super::{FINEST, Sample, UNIT};
use nalgebra::Vector3;
use trunnion_core::{AxisValues, Point, Quality, Slot, State};

/// Time that counts as one unit of travel, s.
const UNIT_S: f64 = 10.0;
/// Travel after a reversal below which a block need not be cut, units (20 µm, 0.01°).
const REVERSAL_FINEST: f64 = 0.01;
/// Largest change of speed within a block, share of the axis' highest speed; blocks of the finest width are short enough as they are.
const SPEED_CHANGE: f64 = 0.15;
/// Width from which on changes of speed and reversals are cut ever more coarsely, units.
const COARSE: f64 = 4.0;

/// Sums of one block.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Index of its first sample.
    pub first: u64,
    pub setup: usize,
    pub pass: usize,
    /// True when it goes on from the block before it.
    pub continues: bool,
    count: f64,
    samples: u64,
    mean: Means,
    /// Time, or the count of samples where there is no time.
    timed: bool,
    temperature_degc: Vec<f64>,
    /// Σ (t − t̄)², Σ (t − t̄)(d − d̄), Σ (d − d̄)².
    tt: f64,
    td: [f64; 3],
    dd: [f64; 3],
    /// Variance within the samples themselves where they are means already, mm².
    within: [f64; 3],
    position: AxisValues<(f64, f64)>,
    velocity: AxisValues<(f64, f64)>,
    since_reversal: AxisValues<(f64, f64)>,
    time: (f64, f64),
    /// −1, 0, 1 of each axis; 0 goes with both.
    sign: AxisValues<i8>,
}

#[derive(Clone, Debug)]
struct Means {
    position: AxisValues<f64>,
    direction: AxisValues<f64>,
    velocity: AxisValues<f64>,
    acceleration: AxisValues<f64>,
    since_reversal: AxisValues<f64>,
    time: f64,
    departure_mm: [f64; 3],
}

impl Cell {
    /// A block of one sample.
    pub fn of(sample: &Sample, pass: usize, continues: bool) -> Self {
        let state = &sample.point.state;
        let time = state.time_s.unwrap_or(sample.index as f64);
        let both = |values: &AxisValues<f64>| AxisValues(values.0.map(|x| (x, x)));
        Self {
            first: sample.index,
            setup: state.setup,
            pass,
            continues,
            count: 1.0,
            samples: u64::from(sample.point.samples.max(1)),
            mean: Means {
                position: state.position,
                direction: state.direction,
                velocity: state.velocity,
                acceleration: state.acceleration,
                since_reversal: state.since_reversal,
                time,
                departure_mm: sample.departure_mm,
            },
            timed: state.time_s.is_some(),
            temperature_degc: state.temperature_degc.clone(),
            tt: 0.0,
            td: [0.0; 3],
            dd: [0.0; 3],
            within: sample.point.spread_mm.map(|s| if s.is_finite() { s * s } else { 0.0 }),
            position: both(&state.position),
            velocity: both(&state.velocity),
            since_reversal: both(&AxisValues(state.since_reversal.0.map(f64::abs))),
            time: (time, time),
            sign: AxisValues(state.direction.0.map(sign)),
        }
    }

    /// Whether `next` may become part of this block when blocks are `width` units wide.
    pub fn may_join(&self, next: &Self, width: f64, top_speed: &AxisValues<f64>, last_resort: bool) -> bool {
        if self.pass != next.pass || (!last_resort && !self.same_way(next)) {
            return false;
        }
        let coarse = (width / COARSE).max(1.0);
        Slot::ALL.into_iter().all(|letter| {
            let unit = UNIT[letter];
            let travel = joined(self.position[letter], next.position[letter]);
            let change = joined(self.velocity[letter], next.velocity[letter]);
            let steady = change.1 - change.0 <= SPEED_CHANGE * coarse * top_speed[letter];
            let since = joined(self.since_reversal[letter], next.since_reversal[letter]);
            let moves = travel.1 > travel.0;
            let floor = REVERSAL_FINEST * coarse * unit;
            let near_reversal = moves && since.1 > 0.0 && since.0 < width * unit;
            travel.1 - travel.0 <= width * unit
                && (steady || width <= FINEST)
                && (!near_reversal || since.1 <= 2.0 * coarse * since.0.max(floor) || last_resort)
        }) && (!self.timed || joined(self.time, next.time).1 - self.time.0 <= width * UNIT_S)
    }

    /// True when no axis turns round between the two.
    pub fn same_way(&self, next: &Self) -> bool {
        self.sign.0.iter().zip(&next.sign.0).all(|(a, b)| a * b >= 0)
    }

    /// Adds the block that follows.
    pub fn merge(&mut self, next: &Self) {
        let count = self.count + next.count;
        let share = next.count / count;
        let lever = self.count * share;
        let (dt, dd): (f64, [f64; 3]) = (
            next.mean.time - self.mean.time,
            std::array::from_fn(|k| next.mean.departure_mm[k] - self.mean.departure_mm[k]),
        );
        self.tt += next.tt + lever * dt * dt;
        for k in 0..3 {
            self.td[k] += next.td[k] + lever * dt * dd[k];
            self.dd[k] += next.dd[k] + lever * dd[k] * dd[k];
            self.within[k] += (next.within[k] - self.within[k]) * share;
            self.mean.departure_mm[k] += dd[k] * share;
        }
        self.mean.time += dt * share;
        for (mine, theirs) in [
            (&mut self.mean.position, &next.mean.position),
            (&mut self.mean.direction, &next.mean.direction),
            (&mut self.mean.velocity, &next.mean.velocity),
            (&mut self.mean.acceleration, &next.mean.acceleration),
            (&mut self.mean.since_reversal, &next.mean.since_reversal),
        ] {
            for (m, x) in mine.0.iter_mut().zip(&theirs.0) {
                *m += (x - *m) * share;
            }
        }
        for (m, x) in self.temperature_degc.iter_mut().zip(&next.temperature_degc) {
            *m += (x - *m) * share;
        }
        for letter in Slot::ALL {
            self.position[letter] = joined(self.position[letter], next.position[letter]);
            self.velocity[letter] = joined(self.velocity[letter], next.velocity[letter]);
            self.since_reversal[letter] = joined(self.since_reversal[letter], next.since_reversal[letter]);
            if self.sign[letter] == 0 {
                self.sign[letter] = next.sign[letter];
            }
        }
        self.time = joined(self.time, next.time);
        self.count = count;
        self.samples += next.samples;
    }

    /// Mean departure from the nominal reading, mm.
    pub fn departure_mm(&self) -> [f64; 3] {
        self.mean.departure_mm
    }

    pub fn mean_time(&self) -> f64 {
        self.mean.time
    }

    pub fn time_variance(&self) -> f64 {
        self.tt / self.count
    }

    /// Largest travel of any axis, units.
    pub fn width(&self) -> f64 {
        self.position.iter().map(|(letter, (low, high))| (high - low) / UNIT[letter]).fold(0.0, f64::max)
    }

    /// The state at the mean time. The mean of a curved path lies inside the curve: `q(t̄) = q̄ − ½ a var(t)`.
    pub fn state(&self) -> State {
        let sagitta = if self.timed { 0.5 * self.time_variance() } else { 0.0 };
        let on_path = |letter: Slot| {
            let (low, high) = self.position[letter];
            (self.mean.position[letter] - self.mean.acceleration[letter] * sagitta).clamp(low, high)
        };
        State {
            position: AxisValues::from_fn(on_path),
            // Exactly at a turning point an axis has no direction; it is that of the block.
            direction: AxisValues::from_fn(|letter| {
                let mean = self.mean.direction[letter];
                if mean.abs() > 0.5 { f64::from(self.sign[letter]) } else { mean }
            }),
            velocity: self.mean.velocity,
            acceleration: self.mean.acceleration,
            since_reversal: self.mean.since_reversal,
            time_s: self.timed.then_some(self.mean.time),
            temperature_degc: self.temperature_degc.clone(),
            setup: self.setup,
            target: 0,
            deflection_mm: Vector3::zeros(),
        }
    }

    /// Standard deviation of the samples about their own straight line over time, mm.
    pub fn scatter_mm(&self) -> [f64; 3] {
        let degrees_of_freedom = self.degrees_of_freedom();
        std::array::from_fn(|k| {
            let along = if self.tt > 0.0 { self.td[k] * self.td[k] / self.tt } else { 0.0 };
            let about = if degrees_of_freedom > 0.0 {
                (self.dd[k] - along).max(0.0) / degrees_of_freedom
            } else {
                0.0
            };
            (about + self.within[k]).sqrt()
        })
    }

    /// Of [`Self::scatter_mm`].
    pub fn degrees_of_freedom(&self) -> f64 {
        (self.count - 2.0).max(0.0)
    }

    /// Standard error of the mean by the noise of its pass, mm; wider where the block itself scatters more than its pass does.
    pub fn standard_error_mm(&self, noise: &Noise) -> [f64; 3] {
        let scatter_mm = self.scatter_mm();
        std::array::from_fn(|k| {
            let usual_mm = noise.scatter_mm[k];
            let unusual =
                if self.count >= 8.0 && usual_mm > 0.0 { (scatter_mm[k] / usual_mm).max(1.0) } else { 1.0 };
            noise.standard_error_mm(k, self.count) * unusual
        })
    }

    /// The block as a point: `spread/√samples` is its standard error.
    pub fn point(&self, state: State, reading_mm: [f64; 3], u_mm: [f64; 3]) -> Point {
        let samples = u32::try_from(self.samples).unwrap_or(u32::MAX);
        Point {
            state,
            reading_mm,
            spread_mm: u_mm.map(|u| u * f64::from(samples).sqrt()),
            samples,
            quality: Quality::Good,
        }
    }
}

fn joined((a_low, a_high): (f64, f64), (b_low, b_high): (f64, f64)) -> (f64, f64) {
    (a_low.min(b_low), a_high.max(b_high))
}

fn sign(direction: f64) -> i8 {
    i8::from(direction > 0.0) - i8::from(direction < 0.0)
}
