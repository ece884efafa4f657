//! Motion that a table does not state: directions and travel from point to point, speeds and accelerations from three neighbours.
//!
//! v(t₂) = slope, a(t₂) = curvature of the parabola through (t₁,q₁), (t₂,q₂), (t₃,q₃); at both ends of a stretch the slope to the only neighbour.
//! Without time the feed gives the speed along the path.

use trunnion_core::direction::Travel;
use trunnion_core::{AxisSample, AxisValues, Joint, Point, Slot};

/// Points further apart than this are not on one path, s: as when samples become blocks.
const PAUSE_S: f64 = 0.25;

/// One row as a point, with its feed (mm/s) and what the encoders read.
pub struct Taken {
    pub point: Point,
    pub feed_mm_per_s: Option<f64>,
    pub actual: Option<AxisSample>,
}

/// What is to be filled.
pub struct Wanted {
    /// Axes whose direction no column states.
    pub directions: Vec<Joint>,
    pub since_reversal: bool,
    pub speeds: bool,
    pub accelerations: bool,
}

/// Passes points on, one row late, with their motion.
pub struct Motion {
    wanted: Wanted,
    travel: Travel,
    before: Option<(usize, Option<f64>, AxisValues<f64>)>,
    waiting: Option<Taken>,
}

impl Motion {
    pub fn new(wanted: Wanted) -> Self {
        Self { wanted, travel: Travel::default(), before: None, waiting: None }
    }

    /// Takes a row; gives the one before it.
    pub fn push(&mut self, mut next: Taken) -> Option<Taken> {
        let stated = next.point.state.since_reversal;
        self.travel.fill(&mut next.point.state, &self.wanted.directions);
        if !self.wanted.since_reversal {
            next.point.state.since_reversal = stated;
        }
        let ready = self.waiting.take().map(|taken| self.moved(taken, Some(&next)));
        self.waiting = Some(next);
        ready
    }

    /// The last row.
    pub fn finish(&mut self) -> Option<Taken> {
        let last = self.waiting.take()?;
        Some(self.moved(last, None))
    }

    fn moved(&mut self, mut taken: Taken, after: Option<&Taken>) -> Taken {
        let state = &mut taken.point.state;
        let here = (state.setup, state.time_s, state.position);
        let after = after.map(|taken| {
            let state = &taken.point.state;
            (state.setup, state.time_s, state.position)
        });
        let on_path = |other: &(usize, Option<f64>, AxisValues<f64>)| {
            let apart_s = other.1.zip(here.1).map_or(0.0, |(other, here)| (other - here).abs());
            other.0 == here.0 && apart_s <= PAUSE_S
        };
        let (before, after) = (self.before.replace(here).filter(&on_path), after.filter(&on_path));
        for slot in Slot::ALL {
            let q = here.2[slot];
            let step = |other: Option<(usize, Option<f64>, AxisValues<f64>)>| {
                let (_, time_s, position) = other?;
                let dt = time_s? - here.1?;
                (dt != 0.0).then(|| (dt, (position[slot] - q) / dt))
            };
            let (speed, acceleration) = match (step(before), step(after)) {
                (Some((back, slope_back)), Some((ahead, slope_ahead))) => {
                    let half = (slope_ahead - slope_back) / (ahead - back);
                    (slope_back - half * back, 2.0 * half)
                }
                (Some((_, slope)), None) | (None, Some((_, slope))) => (slope, 0.0),
                (None, None) => (0.0, 0.0),
            };
            if self.wanted.speeds {
                state.velocity[slot] = speed;
            }
            if self.wanted.accelerations {
                state.acceleration[slot] = acceleration;
            }
        }
        if let (true, None, Some(feed)) = (self.wanted.speeds, here.1, taken.feed_mm_per_s) {
            let ends = (before.unwrap_or(here).2, after.unwrap_or(here).2);
            let travel = AxisValues::from_fn(|slot| ends.1[slot] - ends.0[slot]);
            let linear =
                travel.iter().filter(|(slot, _)| !slot.is_rotary()).map(|(_, d)| d * d).sum::<f64>().sqrt();
            if linear > 0.0 {
                state.velocity = AxisValues::from_fn(|slot| travel[slot] * feed / linear);
            }
        }
        taken
    }
}
