//! When a pose counts as reached.

use crate::interval::USUAL_GAP_S;
use trunnion_core::{AxisValues, Joint};
use trunnion_cycles::cycle::{Pose, Settle};

/// Rules of a static cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticRules {
    /// When a point may be read (from the cycle file).
    pub settle: Settle,
    /// Largest distance of a linear axis from the pose, mm.
    pub near_mm: f64,
    /// Largest distance of a rotary axis from the pose, rad.
    pub near_rad: f64,
    /// Longest distance of two samples inside a window, s; longer for probes that are read more slowly.
    pub sample_gap_s: f64,
    /// Fewest samples of a point. The window of probes that are read slowly is as long as these take.
    pub fewest_samples: usize,
    /// Standing longer than this with nothing left to read ends the cycle, s.
    pub end_after_still_s: f64,
}

impl StaticRules {
    /// Usual rules around those of the cycle file.
    pub fn new(settle: Settle) -> Self {
        Self {
            settle,
            near_mm: 0.5,
            near_rad: 0.01,
            sample_gap_s: USUAL_GAP_S,
            fewest_samples: 5,
            end_after_still_s: 120.0,
        }
    }

    /// Length of a window of probes that are read so often, s: at least that of the cycle file, and as long as the fewest samples and
    /// one more take.
    pub fn window_s(&self, interval_s: f64) -> f64 {
        self.settle.window_s.max(interval_s * (self.fewest_samples.max(2) + 1) as f64)
    }

    /// For a cycle whose program waits so long between two rounds, s: that standing still is not its end.
    pub fn with_wait(self, wait_s: f64) -> Self {
        Self { end_after_still_s: self.end_after_still_s + wait_s, ..self }
    }

    pub(super) fn is_near(&self, position: &AxisValues<f64>, pose: &Pose, axes: &[Joint]) -> bool {
        is_near(position, &pose.position, axes, (self.near_mm, self.near_rad))
    }
}

/// A place of the axes at which a pose counts as reached.
#[derive(Clone, Debug)]
pub struct StandsAt {
    position: AxisValues<f64>,
    axes: Vec<Joint>,
    near: (f64, f64),
}

impl StandsAt {
    /// The place of a pose by the rules of a static cycle.
    pub fn pose(pose: &Pose, axes: Vec<Joint>, rules: &StaticRules) -> Self {
        Self { position: pose.position, axes, near: (rules.near_mm, rules.near_rad) }
    }

    /// True within the limits of the rules.
    pub fn is_near(&self, position: &AxisValues<f64>) -> bool {
        is_near(position, &self.position, &self.axes, self.near)
    }
}

fn is_near(
    a: &AxisValues<f64>,
    b: &AxisValues<f64>,
    axes: &[Joint],
    (near_mm, near_rad): (f64, f64),
) -> bool {
    axes.iter().all(|&letter| {
        let off = a[letter] - b[letter];
        if letter.is_rotary() { whole_turns_off(off).abs() <= near_rad } else { off.abs() <= near_mm }
    })
}

/// A controller may show an angle modulo a turn.
fn whole_turns_off(angle_rad: f64) -> f64 {
    angle_rad - (angle_rad / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
