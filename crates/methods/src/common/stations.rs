//! Angles at which the passes of an axis are compared and averaged: the poses of a grid, or bins of a sweep.
//!
//! Bins are as narrow as the readings of one pass allow (1° at the finest). What varies fast (the once-a-turn phasor of the
//! setting) is taken off the readings before they are binned, at their own angles, so that nothing is smeared.

use std::f64::consts::TAU;
use trunnion_core::convert::rad_from_deg;
use trunnion_core::statistics::upper_median;

/// Narrowest and widest bin.
const FINEST_RAD: f64 = rad_from_deg(1.0);
const COARSEST_RAD: f64 = rad_from_deg(15.0);
/// Poses of a grid nearer than this are one.
const SAME_RAD: f64 = rad_from_deg(0.01);

/// The angles.
#[derive(Clone, Debug)]
pub(crate) struct Stations {
    /// Middle of each station, rad, rising.
    pub angles_rad: Vec<f64>,
    reach_rad: f64,
    turn: bool,
}

impl Stations {
    /// Poses that `angles` hold, wrapped to one turn when the axis goes around.
    pub fn of_grid(angles: impl Iterator<Item = f64>, turn: bool) -> Self {
        let mut all: Vec<f64> = angles.map(|angle| wrapped(angle, turn)).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|next, kept| *next - *kept < SAME_RAD);
        if turn && all.len() > 1 && all[0] + TAU - all[all.len() - 1] < SAME_RAD {
            all.pop();
        }
        Self { angles_rad: all, reach_rad: SAME_RAD, turn }
    }

    /// Bins for sweeps; `angles` in the order they were read.
    pub fn of_sweeps(angles: &[f64], turn: bool) -> Self {
        let steps: Vec<f64> =
            angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 1e-9).collect();
        let usual = upper_median(&steps).unwrap_or(COARSEST_RAD);
        let width = usual.clamp(FINEST_RAD, COARSEST_RAD);
        let (low, high) = if turn {
            (0.0, TAU)
        } else {
            let ends =
                angles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(*a), h.max(*a)));
            // Readings in the middle of their stations, not at the edges.
            (ends.0 - width / 2.0, ends.1 + width / 2.0)
        };
        let count = ((high - low) / width).round().max(1.0);
        let width = (high - low) / count;
        let angles_rad = (0..count as usize).map(|i| low + width * (i as f64 + 0.5)).collect();
        Self { angles_rad, reach_rad: width / 2.0, turn }
    }

    /// The station of an angle; `None` when it is near none.
    pub fn at(&self, angle_rad: f64) -> Option<usize> {
        let angle = wrapped(angle_rad, self.turn);
        let after = self.angles_rad.partition_point(|station| *station < angle);
        let near = |i: usize| {
            let apart = (self.angles_rad[i] - angle).abs();
            if self.turn { apart.min(TAU - apart) } else { apart }
        };
        let count = self.angles_rad.len();
        if count == 0 {
            return None;
        }
        let nearest = [after % count, (after + count - 1) % count]
            .into_iter()
            .min_by(|&a, &b| near(a).total_cmp(&near(b)))?;
        (near(nearest) <= self.reach_rad * (1.0 + 1e-9)).then_some(nearest)
    }
}

fn wrapped(angle_rad: f64, turn: bool) -> f64 {
    if turn { angle_rad.rem_euclid(TAU) } else { angle_rad }
}
