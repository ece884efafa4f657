//! When a pose counts as reached.

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
    /// Longest distance of two samples inside a window, s.
    pub sample_gap_s: f64,
    /// Fewest samples of a point.
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
            sample_gap_s: 0.05,
            fewest_samples: 5,
            end_after_still_s: 120.0,
        }
    }

    /// For a cycle whose program waits so long between two rounds, s: that standing still is not its end.
    pub fn with_wait(self, wait_s: f64) -> Self {
        Self { end_after_still_s: self.end_after_still_s + wait_s, ..self }
    }

    pub(super) fn is_near(&self, position: &AxisValues<f64>, pose: &Pose, axes: &[Joint]) -> bool {
        axes.iter().all(|&letter| {
            let off = position[letter] - pose.position[letter];
            if letter.is_rotary() {
                whole_turns_off(off).abs() <= self.near_rad
            } else {
                off.abs() <= self.near_mm
            }
        })
    }
}

/// A controller may show an angle modulo a turn.
fn whole_turns_off(angle_rad: f64) -> f64 {
    angle_rad - (angle_rad / std::f64::consts::TAU).round() * std::f64::consts::TAU
}
