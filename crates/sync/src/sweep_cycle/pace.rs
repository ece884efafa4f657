//! How fast the axes move, from positions whose stamps jitter.
//! q(t) = a + v (t − t₀) + ½ c (t − t₀)² through the positions around t₀, by least squares.
//! v velocity, c acceleration; s scatter of the swept axis about its own parabola; u(v) and u(c) by s and the normal equations.
//! Second differences of neighbours carry √6·j·v/h² of a jitter j at a step h: 48 rad/s² at 7200°/min, 125 Hz and 0.6 ms, where
//! half a turn a second² is a ramp. Over 0.1 s u(v) is 0.6 % and u(c) 0.9 rad/s² there.
//! Valid while the third derivative is small over the window: at 7200°/min the velocity of an axis that follows a circle is 0.3 %
//! low.

use crate::align::AxisState;
use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;
use trunnion_core::AxisValues;

/// Positions within this of an instant count, s.
pub(super) const HALF_S: f64 = 0.05;
/// A controller that shows its axes seldom is looked at so far on both sides, s: half of what the alignment bridges.
const FARTHEST_S: f64 = 0.375;
/// Positions on each side of the instant that are waited for.
const NEIGHBOURS: usize = 2;
/// A parabola through three points says nothing of its scatter.
const FEWEST: usize = 4;

/// Axis positions as recorded, and where along its course the machine was.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub time_s: f64,
    pub position: AxisValues<f64>,
    /// Along the course, rad.
    pub angle: f64,
    /// Departure from the course of a setup, once it was asked for.
    pub departure: Option<(usize, Option<AxisValues<f64>>)>,
}

/// The motion at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    pub velocity: AxisValues<f64>,
    pub acceleration: AxisValues<f64>,
    /// Angle along the course, rad: that of the parabola, which a stamp alone does not move.
    pub angle: f64,
    /// Of the angle along the course, rad/s and rad/s², with their standard uncertainties.
    pub pace: (f64, f64),
    pub u_pace: (f64, f64),
    /// Scatter of the angle about its parabola, rad.
    pub scatter_rad: f64,
}

/// Positions around the instants asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Pace {
    nodes: VecDeque<Node>,
}

impl Pace {
    pub(super) fn push(&mut self, state: &AxisState, angle: f64) {
        let node = Node { time_s: state.time_s, position: state.position, angle, departure: None };
        self.nodes.push_back(node);
    }

    /// The last angle along the course.
    pub(super) fn last_angle(&self) -> Option<f64> {
        self.nodes.back().map(|node| node.angle)
    }

    /// True when later positions would change nothing.
    pub(super) fn is_known_around(&self, time_s: f64) -> bool {
        let after = self.nodes.iter().rev().take_while(|node| node.time_s > time_s).count();
        let newest_s = self.nodes.back().map_or(f64::NEG_INFINITY, |node| node.time_s);
        newest_s > time_s + FARTHEST_S || (newest_s > time_s + HALF_S && after >= NEIGHBOURS)
    }

    /// Forgets what instants from `time_s` on do not need.
    pub(super) fn forget_before(&mut self, time_s: f64) {
        while self.nodes.get(NEIGHBOURS + 1).is_some_and(|node| node.time_s < time_s - HALF_S) {
            self.nodes.pop_front();
        }
    }

    /// The positions before and after an instant, and how far between them it is, 0 to 1.
    pub(super) fn around(&mut self, time_s: f64) -> Option<([&mut Node; 2], f64)> {
        let after = self.nodes.partition_point(|node| node.time_s <= time_s);
        let last = self.nodes.len().checked_sub(2)?;
        let first = after.checked_sub(1)?.min(last);
        let (a, b) = {
            let (head, tail) = self.nodes.make_contiguous().split_at_mut(first + 1);
            (head.last_mut()?, tail.first_mut()?)
        };
        let share = ((time_s - a.time_s) / (b.time_s - a.time_s)).clamp(0.0, 1.0);
        Some(([a, b], share))
    }

    /// The motion at an instant; `None` with too few positions around it.
    pub(super) fn motion(&self, time_s: f64) -> Option<Motion> {
        let middle = self.nodes.partition_point(|node| node.time_s <= time_s);
        let near = |reach_s: f64| {
            let from = self.nodes.partition_point(|node| node.time_s < time_s - reach_s);
            (from, self.nodes.partition_point(|node| node.time_s <= time_s + reach_s))
        };
        let ((narrow_from, narrow_to), (wide_from, wide_to)) = (near(HALF_S), near(FARTHEST_S));
        let from = narrow_from.min(middle.saturating_sub(NEIGHBOURS)).max(wide_from);
        let to = narrow_to.max(middle + NEIGHBOURS).min(wide_to);
        let count = to.checked_sub(from).filter(|count| *count >= FEWEST)?;
        let times = || self.nodes.range(from..to).map(|node| node.time_s - time_s);
        let row = |t: f64| Vector3::new(1.0, t, 0.5 * t * t);
        let normal: Matrix3<f64> = times().map(|t| row(t) * row(t).transpose()).sum();
        let covariance = normal.try_inverse()?;
        let fit = |value: &dyn Fn(&Node) -> f64| -> Vector3<f64> {
            let nodes = self.nodes.range(from..to);
            covariance * times().zip(nodes).map(|(t, node)| row(t) * value(node)).sum::<Vector3<f64>>()
        };
        // From the first on: an axis that stands has no speed at all, not one of rounding.
        let first = &self.nodes.get(from)?.position;
        let each: AxisValues<Vector3<f64>> =
            AxisValues::from_fn(|slot| fit(&|node| node.position[slot] - first[slot]));
        let angle = fit(&|node| node.angle);
        let off = |(t, node): (f64, &Node)| (node.angle - row(t).dot(&angle)).powi(2);
        let squares: f64 = times().zip(self.nodes.range(from..to)).map(off).sum();
        let scatter_rad = (squares / (count - 3) as f64).sqrt();
        Some(Motion {
            velocity: AxisValues::from_fn(|slot| each[slot][1]),
            acceleration: AxisValues::from_fn(|slot| each[slot][2]),
            angle: angle[0],
            pace: (angle[1], angle[2]),
            u_pace: (scatter_rad * covariance[(1, 1)].sqrt(), scatter_rad * covariance[(2, 2)].sqrt()),
            scatter_rad,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::Joint;

    /// 125 Hz at 2 rad/s; every second stamp is late by `late_s`.
    fn pace(late_s: f64) -> Pace {
        let mut pace = Pace::default();
        for k in 0..40 {
            let time_s = f64::from(k) * 0.008;
            let mut position = AxisValues::default();
            position[Joint::C] = 2.0 * time_s;
            position[Joint::Z] = 60.1;
            let late_s = if k % 2 == 0 { late_s } else { 0.0 };
            let none = AxisValues::default();
            let state = AxisState {
                time_s: time_s + late_s,
                position,
                velocity: none,
                acceleration: none,
                direction: none,
                since_reversal: none,
            };
            pace.push(&state, position[Joint::C]);
        }
        pace
    }

    #[test]
    fn the_speed_is_that_of_the_window_and_its_uncertainty_follows_the_jitter() {
        let steady = pace(0.0).motion(0.15).unwrap();
        assert!((steady.pace.0 - 2.0).abs() < 1e-9 && steady.pace.1.abs() < 1e-6 && steady.u_pace.0 < 1e-9);
        let jittery = pace(0.001).motion(0.15).unwrap();
        // Half a millisecond about the mean is 1 mrad.
        assert!((jittery.scatter_rad - 1e-3).abs() < 2e-4, "{jittery:?}");
        assert!((jittery.pace.0 - 2.0).abs() < 3.0 * jittery.u_pace.0 && jittery.u_pace.0 < 0.02);
        assert!((jittery.velocity[Joint::C] - jittery.pace.0).abs() < 1e-9);
        // Half a millisecond about the mean is 1 mrad between two positions, and less in the middle of a window of twelve.
        let angle = |time_s: f64| jittery_angle(time_s) - 2.0 * (time_s - 0.0005);
        assert!((0..10).all(|k| angle(0.12 + 0.004 * f64::from(k)).abs() < 3e-4));
        assert_eq!((jittery.velocity[Joint::Z], jittery.acceleration[Joint::Z]), (0.0, 0.0), "it stands");
    }

    fn jittery_angle(time_s: f64) -> f64 {
        pace(0.001).motion(time_s).unwrap().angle
    }

    #[test]
    fn a_controller_that_shows_its_axes_seldom_is_looked_at_farther_off() {
        let mut pace = Pace::default();
        let mut state = AxisState { ..seldom() };
        for k in 0..10 {
            state.time_s = f64::from(k) * 0.12;
            pace.push(&state, 0.5 * state.time_s);
        }
        assert!((pace.motion(0.5).unwrap().pace.0 - 0.5).abs() < 1e-9);
        assert!(pace.is_known_around(0.9) && !pace.is_known_around(1.0));
    }

    fn seldom() -> AxisState {
        let none = AxisValues::default();
        AxisState {
            time_s: 0.0,
            position: none,
            velocity: none,
            acceleration: none,
            direction: none,
            since_reversal: none,
        }
    }
}
