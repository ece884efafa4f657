//! Angles at which the passes of an axis are compared and averaged: the poses of a grid, or bins of a sweep.
//!
//! Bins are as narrow as the readings of one pass allow (1° at the finest). What varies fast (the once-a-turn phasor of the
//! setting) is taken off the readings before they are binned, at their own angles, so that nothing is smeared.

use nalgebra::Vector2;
use std::f64::consts::TAU;
use trunnion_core::convert::rad_from_deg;
use trunnion_core::statistics::upper_median;

/// Narrowest and widest bin.
const FINEST_RAD: f64 = rad_from_deg(1.0);
const COARSEST_RAD: f64 = rad_from_deg(15.0);
/// Poses of a grid nearer than this are one.
const SAME_RAD: f64 = rad_from_deg(0.01);
/// Readings share a place in their stations where the mean of their phases is so long: of a normal scatter by a fifth of a station.
const SHARED: f64 = 0.5;
/// A place so near an edge, in stations, is moved away from it: half the readings with that scatter would be beyond.
const CLEAR: f64 = 0.25;

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
            let width = TAU / (TAU / width).round().max(1.0);
            let low = edge(angles, width);
            (low, low + TAU)
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

    /// Mean of values over angles (rad) at each station; `None` at stations without any.
    pub fn means(&self, values: impl Iterator<Item = (f64, f64)>) -> Vec<Option<f64>> {
        let mut sums = vec![(0.0, 0.0); self.angles_rad.len()];
        for (angle_rad, value) in values {
            if let Some(i) = self.at(angle_rad) {
                sums[i] = (sums[i].0 + value, sums[i].1 + 1.0);
            }
        }
        sums.into_iter().map(|(sum, count)| (count > 0.0).then(|| sum / count)).collect()
    }

    /// The same as angle and mean, without the stations that have none.
    pub fn contour(&self, values: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
        let means = self.means(values).into_iter().zip(&self.angles_rad);
        means.filter_map(|(mean, &angle_rad)| Some((angle_rad, mean?))).collect()
    }
}

/// An edge of stations that go around, in 0…width: at zero; where readings share a place near there, half a station away from them. On an edge,
/// rounding would put a reading of one turn into this station and the same of the next turn into that one.
fn edge(angles: &[f64], width: f64) -> f64 {
    let place = |angle: &f64| Vector2::new((TAU * angle / width).cos(), (TAU * angle / width).sin());
    let mean = angles.iter().map(place).sum::<Vector2<f64>>() / angles.len().max(1) as f64;
    let shared = mean.y.atan2(mean.x) / TAU;
    if mean.norm() < SHARED || shared.abs() > CLEAR { 0.0 } else { (shared + 0.5) * width }
}

fn wrapped(angle_rad: f64, turn: bool) -> f64 {
    if turn { angle_rad.rem_euclid(TAU) } else { angle_rad }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_on_the_edges_of_stations_leave_hardly_any_empty() {
        // Every 3° from a whole turn on, as a table of four decimals has them, and with a scatter of 0.3°.
        let mut scatter = (0_u64..).map(|i| ((i * 7919) % 1000) as f64 / 1000.0 - 0.5);
        for scattered in [0.0, 1.0] {
            let mut turn = |p: u64| -> Vec<(f64, f64)> {
                let angle = |i: u64| f64::from(u32::try_from(360 * p + 3 * i).unwrap()) - 720.0;
                let read = (0..120).map(|i| angle(i) + scattered * scatter.next().unwrap());
                read.map(|deg| (((deg * 1e4).round() / 1e4).to_radians(), 1.0)).collect()
            };
            let turns: Vec<Vec<(f64, f64)>> = (0..4).map(&mut turn).collect();
            let angles: Vec<f64> = turns.iter().flatten().map(|(angle, _)| *angle).collect();
            let stations = Stations::of_sweeps(&angles, true);
            for turn in &turns {
                let filled = stations.means(turn.iter().copied()).iter().flatten().count();
                // Of a scatter the usual step is a little less than the mean one, so there are a few stations more than readings.
                let least = if scattered > 0.0 { 0.95 } else { 1.0 };
                assert!(filled as f64 >= least * stations.angles_rad.len() as f64, "{filled}, {scattered}");
            }
        }
    }
}
