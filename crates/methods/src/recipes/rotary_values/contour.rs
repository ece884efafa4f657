//! Turns of one signal about their least-squares centre, and the three values [ISO 230-7 clause 3].

use nalgebra::{DMatrix, DVector};
use trunnion_engine::solve::linear::least_squares;

/// A signal over the stations, turn by turn; `None` where a turn has no reading.
#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    pub turns: Vec<Vec<Option<f64>>>,
}

/// The turns of one direction about their centre.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    /// Turns behind it.
    pub turns: usize,
    /// Mean over the turns at each station, its angle first.
    pub mean: Vec<(f64, f64)>,
    /// Lowest and highest of the turns at each station.
    pub lowest: Vec<(f64, f64)>,
    /// See `lowest`.
    pub highest: Vec<(f64, f64)>,
    /// max − min of everything.
    pub total: f64,
    /// max − min of the mean; `None` for a single turn.
    pub synchronous: Option<f64>,
    /// Largest width over the turns; `None` for a single turn.
    pub asynchronous: Option<f64>,
    /// Range of the once-a-turn part that was taken off.
    pub fundamental: f64,
}

impl Contour {
    /// `None` when there are too few readings to have a centre.
    pub fn of(angles_rad: &[f64], signal: &Signal) -> Option<Self> {
        let samples: Vec<(usize, f64)> = signal
            .turns
            .iter()
            .flat_map(|turn| turn.iter().enumerate().filter_map(|(i, value)| Some((i, (*value)?))))
            .collect();
        if samples.len() < 6 {
            return None;
        }
        let row = |angle: f64| [1.0, angle.cos(), angle.sin()];
        let design = DMatrix::from_fn(samples.len(), 3, |n, k| row(angles_rad[samples[n].0])[k]);
        let values = DVector::from_iterator(samples.len(), samples.iter().map(|(_, value)| *value));
        let centre = least_squares(&design, &values, 1e-9).x;
        let about_centre = |i: usize, value: f64| {
            let row = row(angles_rad[i]);
            value - (0..3).map(|k| row[k] * centre[k]).sum::<f64>()
        };
        let (mut mean, mut lowest, mut highest, mut width) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        let turns = signal.turns.len();
        for (i, &angle) in angles_rad.iter().enumerate() {
            let here = signal.turns.iter().filter_map(|turn| Some(about_centre(i, turn[i]?)));
            let here: Vec<f64> = here.collect();
            let (low, high) = extent(here.iter().copied());
            if here.is_empty() {
                continue;
            }
            if here.len() == turns {
                width = f64::max(width, high - low);
            }
            mean.push((angle, here.iter().sum::<f64>() / here.len() as f64));
            lowest.push((angle, low));
            highest.push((angle, high));
        }
        let range = |of: &[(f64, f64)]| {
            let (low, high) = extent(of.iter().map(|(_, value)| *value));
            high - low
        };
        let everything = extent(lowest.iter().chain(&highest).map(|(_, value)| *value));
        Some(Self {
            turns,
            total: everything.1 - everything.0,
            synchronous: (turns > 1).then(|| range(&mean)),
            asynchronous: (turns > 1).then_some(width),
            fundamental: 2.0 * centre[1].hypot(centre[2]),
            mean,
            lowest,
            highest,
        })
    }

    /// Largest distance between two mean contours at common angles.
    pub fn apart(&self, other: &Self) -> f64 {
        let at = |angle: f64| other.mean.iter().find(|(a, _)| *a == angle).map(|(_, value)| *value);
        self.mean.iter().filter_map(|(angle, value)| Some((value - at(*angle)?).abs())).fold(0.0, f64::max)
    }
}

fn extent(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn turns(count: usize, of: impl Fn(usize, f64) -> f64) -> (Vec<f64>, Signal) {
        let angles: Vec<f64> = (0..72).map(|i| TAU * i as f64 / 72.0).collect();
        let turn = |p: usize| angles.iter().map(|&angle| Some(of(p, angle))).collect();
        let turns = (0..count).map(turn).collect();
        (angles, Signal { turns })
    }

    fn check(count: usize, of: impl Fn(usize, f64) -> f64, [total, synchronous, asynchronous]: [f64; 3]) {
        let (angles, signal) = turns(count, of);
        let contour = Contour::of(&angles, &signal).expect("many readings");
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} is not {b}: {contour:?}");
        near(contour.total, total);
        near(contour.synchronous.expect("two turns"), synchronous);
        near(contour.asynchronous.expect("two turns"), asynchronous);
    }

    #[test]
    fn values_are_those_computed_by_hand() {
        // Three lobes of 2, eccentricity 50, offset 7: total = synchronous = 4, nothing asynchronous.
        check(3, |_, t| 2.0 * (3.0 * t).cos() + 50.0 * (t + 1.0).cos() + 7.0, [4.0, 4.0, 0.0]);
        // Every other turn 0.5 higher and lower: the mean is the same, the plot 1 wide.
        check(4, |p, t| 2.0 * (3.0 * t).cos() + if p % 2 == 0 { 0.5 } else { -0.5 }, [5.0, 4.0, 1.0]);
        // Half a lobe too much a turn (a bearing cage): cos 2.5t alternates in sign from turn to turn.
        check(2, |p, t| (2.5 * (t + TAU * p as f64)).cos(), [2.0, 0.0, 2.0]);
    }

    #[test]
    fn a_single_turn_gives_the_total_alone() {
        let (angles, signal) = turns(1, |_, t| 2.0 * (4.0 * t).cos());
        let contour = Contour::of(&angles, &signal).expect("many readings");
        assert!((contour.total - 4.0).abs() < 1e-9);
        assert_eq!((contour.synchronous, contour.asynchronous), (None, None));
    }
}
