//! Turns of one signal about their least-squares centre, and the three values [ISO 230-7 clause 3].

use crate::common::stations::Stations;
use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_engine::solve::linear::least_squares;

/// Fewer readings have no centre.
const LEAST_READINGS: usize = 6;

/// One turn as read: angle (rad) and value.
pub(super) type Turn = Vec<(f64, f64)>;

/// A signal of one direction about its centre, over the stations.
#[derive(Clone, Debug)]
pub(super) struct Signal {
    /// s̄, a, b of the centre.
    centre: Vector3<f64>,
    /// Turn by turn; `None` where a turn has no reading.
    turns: Vec<Vec<Option<f64>>>,
}

impl Signal {
    /// The centre is taken off at the angle of each reading: a ball that sits off the axis varies by more than the error motion within
    /// one station. `None` when there are too few readings to have a centre.
    pub fn of(stations: &Stations, turns: &[Turn]) -> Option<Self> {
        let readings: Vec<(f64, f64)> = turns.iter().flatten().copied().collect();
        if readings.len() < LEAST_READINGS {
            return None;
        }
        let row = |angle: f64| Vector3::new(1.0, angle.cos(), angle.sin());
        let design = DMatrix::from_fn(readings.len(), 3, |n, k| row(readings[n].0)[k]);
        let values = DVector::from_iterator(readings.len(), readings.iter().map(|(_, value)| *value));
        let fit = least_squares(&design, &values, 1e-9);
        let centre = Vector3::from_fn(|k, _| fit.x[k]);
        let about_centre = |turn: &Turn| -> Vec<Option<f64>> {
            let about = turn.iter().map(|&(angle, value)| (angle, value - row(angle).dot(&centre)));
            stations.means(about)
        };
        Some(Self { centre, turns: turns.iter().map(about_centre).collect() })
    }

    /// Every turn of this against every turn of another.
    pub fn less(&self, other: &Self) -> Self {
        let pairs = self.turns.iter().flat_map(|turn| other.turns.iter().map(move |less| (turn, less)));
        let less = |(turn, less): (&Vec<Option<f64>>, &Vec<Option<f64>>)| -> Vec<Option<f64>> {
            turn.iter().zip(less).map(|(value, less)| Some((*value)? - (*less)?)).collect()
        };
        Self { centre: self.centre - other.centre, turns: pairs.map(less).collect() }
    }
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
    /// Over the angles of the stations.
    pub fn of(angles_rad: &[f64], signal: &Signal) -> Self {
        let (mut mean, mut lowest, mut highest, mut width) = (Vec::new(), Vec::new(), Vec::new(), 0.0);
        let turns = signal.turns.len();
        for (i, &angle) in angles_rad.iter().enumerate() {
            let here: Vec<f64> = signal.turns.iter().filter_map(|turn| turn[i]).collect();
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
        Self {
            turns,
            total: everything.1 - everything.0,
            synchronous: (turns > 1).then(|| range(&mean)),
            asynchronous: (turns > 1).then_some(width),
            fundamental: 2.0 * signal.centre.y.hypot(signal.centre.z),
            mean,
            lowest,
            highest,
        }
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

    /// Turns read every `step_rad`, that begin at zero.
    fn contour(count: usize, step_rad: f64, of: impl Fn(usize, f64) -> f64) -> Contour {
        let angles: Vec<f64> =
            (0..).map(|i| step_rad * f64::from(i)).take_while(|angle| *angle < TAU * count as f64).collect();
        let stations = Stations::of_sweeps(&angles, true);
        let of_turn = |p: usize| -> Turn {
            let read = angles.iter().filter(|angle| (**angle / TAU) as usize == p);
            read.map(|&angle| (angle, of(p, angle))).collect()
        };
        let turns: Vec<Turn> = (0..count).map(of_turn).collect();
        Contour::of(&stations.angles_rad, &Signal::of(&stations, &turns).expect("many readings"))
    }

    fn check(count: usize, of: impl Fn(usize, f64) -> f64, [total, synchronous, asynchronous]: [f64; 3]) {
        let contour = contour(count, TAU / 72.0, of);
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
        check(2, |_, t| (2.5 * t).cos(), [2.0, 0.0, 2.0]);
    }

    #[test]
    fn a_single_turn_gives_the_total_alone() {
        let contour = contour(1, TAU / 72.0, |_, t| 2.0 * (4.0 * t).cos());
        assert!((contour.total - 4.0).abs() < 1e-9);
        assert_eq!((contour.synchronous, contour.asynchronous), (None, None));
    }

    #[test]
    fn a_ball_off_the_axis_is_no_error_motion_whatever_the_angles() {
        // 3.1° do not divide a turn: from turn to turn the readings lie elsewhere in the stations.
        for step_rad in [TAU / 72.0, 3.1_f64.to_radians(), 7.7_f64.to_radians(), 17.3_f64.to_radians()] {
            let contour = contour(3, step_rad, |_, t| 100.0 * (t + 1.0).cos() + 7.0);
            let largest = contour.total.max(contour.asynchronous.expect("three turns"));
            assert!(largest < 1e-9, "{largest} every {step_rad} rad");
            assert!((contour.fundamental - 200.0).abs() < 1e-9);
        }
    }
}
