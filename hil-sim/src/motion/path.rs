//! The way of a step through axis space: q(u), u from 0 to 1, where each axis turns round, and derivatives.

use super::program::Follow;
use trunnion_core::{AxisValues, Joint};

/// Step of the difference quotients over u of a followed path.
const H: f64 = 1e-4;
/// Intervals looked through for turning points; a full turn of a followed circle has four.
const INTERVALS: usize = 720;
/// Travel below this is rounding, not motion; mm or rad.
const NO_TRAVEL: f64 = 1e-9;

#[derive(Debug, Clone)]
pub(super) struct Path {
    from: AxisValues<f64>,
    to: AxisValues<f64>,
    follow: Option<Follow>,
    /// Ascending u of the turning points of each axis inside the step, with the position there.
    turns: AxisValues<Vec<(f64, f64)>>,
}

impl Path {
    pub fn straight(from: AxisValues<f64>, to: AxisValues<f64>) -> Self {
        Self { from, to, follow: None, turns: AxisValues::default() }
    }

    /// Driven axes go straight from `from` to `to`, the followers as the function says.
    pub fn followed(from: AxisValues<f64>, to: AxisValues<f64>, follow: Follow) -> Self {
        let mut path = Self { from, to, follow: Some(follow), turns: AxisValues::default() };
        path.turns = path.find_turns();
        path
    }

    pub fn at(&self, u: f64) -> AxisValues<f64> {
        let driven = AxisValues::from_fn(|axis| self.from[axis] + (self.to[axis] - self.from[axis]) * u);
        self.follow.as_ref().map_or(driven, |follow| follow.apply(&driven))
    }

    /// dq/du and d²q/du².
    pub fn derivatives(&self, u: f64) -> (AxisValues<f64>, AxisValues<f64>) {
        if self.follow.is_none() {
            return (AxisValues::from_fn(|axis| self.to[axis] - self.from[axis]), AxisValues::default());
        }
        let (before, here, after) = (self.at(u - H), self.at(u), self.at(u + H));
        let first = AxisValues::from_fn(|axis| (after[axis] - before[axis]) / (2.0 * H));
        let second = AxisValues::from_fn(|axis| (after[axis] - 2.0 * here[axis] + before[axis]) / (H * H));
        (first, second)
    }

    /// The way each axis goes first, the way it goes at u, and the travel since its last turn inside the step
    /// (since the beginning when there was none).
    pub fn travel(&self, axis: Joint, u: f64, position: f64) -> Travel {
        let start = self.at(0.0)[axis];
        let turns = &self.turns[axis];
        let passed = turns.partition_point(|&(turn_u, _)| turn_u <= u);
        let (origin, turned) = match passed.checked_sub(1) {
            Some(last) => (turns[last].1, true),
            None => (start, false),
        };
        let travel = position - origin;
        let moved = travel.abs() > NO_TRAVEL;
        Travel { direction: if moved { travel.signum() } else { 0.0 }, travel: travel.abs(), turned }
    }

    fn find_turns(&self) -> AxisValues<Vec<(f64, f64)>> {
        let grid: Vec<AxisValues<f64>> =
            (0..=INTERVALS).map(|k| self.at(k as f64 / INTERVALS as f64)).collect();
        AxisValues::from_fn(|axis| {
            let value = |u: f64| self.at(u)[axis];
            let mut turns = Vec::new();
            for k in 1..INTERVALS {
                let rise = grid[k][axis] - grid[k - 1][axis];
                let fall = grid[k + 1][axis] - grid[k][axis];
                if rise * fall < 0.0 && rise.abs().max(fall.abs()) > NO_TRAVEL {
                    let u = extremum(value, (k - 1) as f64, (k + 1) as f64, rise.signum());
                    turns.push((u, value(u)));
                }
            }
            turns
        })
    }
}

/// What an axis has done up to some point of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Travel {
    /// −1, +1, or 0 when it has not moved since.
    pub direction: f64,
    /// mm or rad, not negative.
    pub travel: f64,
    /// It turned round inside the step.
    pub turned: bool,
}

/// u of the maximum (`sign` +1) or minimum (−1) between two grid points, by ternary search.
fn extremum(value: impl Fn(f64) -> f64, low: f64, high: f64, sign: f64) -> f64 {
    let (mut low, mut high) = (low / INTERVALS as f64, high / INTERVALS as f64);
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if sign * value(low + third) < sign * value(high - third) { low += third } else { high -= third }
    }
    0.5 * (low + high)
}
