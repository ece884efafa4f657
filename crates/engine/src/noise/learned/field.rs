//! A smooth pattern over the rotary axes that comes back: in which axes, and over which lengths.

use super::Real;
use crate::Experiment;
use crate::problem::taken::Taken;
use crate::solve::pairs::symmetric;
use nalgebra::DMatrix;
use trunnion_core::Joint;

/// A rotary axis that covers this much is taken as closed, rad.
const CLOSED_RAD: f64 = 5.2;

/// The rotary axes over which a pattern may repeat. On linear axes a smooth pattern is a component error, which has a name.
pub(super) struct Axes {
    /// Square of the distance of every pair of points on each, rad², a chord on an axis that closes; slow axis first.
    pub turning: Vec<DMatrix<f64>>,
    points: usize,
}

impl Axes {
    pub fn new(experiment: &Experiment, taken: &Taken) -> Self {
        let points = experiment.points.len();
        let squares = |letter: Joint| {
            let at: Vec<f64> = experiment.points.iter().map(|point| point.state.position[letter]).collect();
            let (low, high) = experiment.scene.position_range[letter];
            let closes = high - low > CLOSED_RAD;
            symmetric(points, |i, j| {
                let turn = at[i] - at[j];
                if closes { (2.0 * (0.5 * turn).sin()).powi(2) } else { turn.powi(2) }
            })
        };
        Self { turning: [taken.slow, taken.fast].into_iter().flatten().map(squares).collect(), points }
    }

    /// exp(−½ Σ (d/ℓ)²); no length: alike along that axis.
    pub fn field(&self, lengths: &[Option<f64>]) -> DMatrix<Real> {
        let axes = self.turning.iter().zip(lengths);
        let axes: Vec<(&DMatrix<f64>, f64)> =
            axes.filter_map(|(squares, length)| Some((squares, (*length)?.powi(-2)))).collect();
        symmetric(self.points, |i, j| {
            let square: f64 = axes.iter().map(|(squares, by)| squares[(i, j)] * by).sum();
            (-0.5 * square).exp()
        })
        .cast()
    }

    /// Mean sizes and lengths (rad, for the slow and the fast axis): round, long along one axis, of one axis alone.
    pub fn lengths_of_readings(&self) -> Vec<(f64, Vec<Option<f64>>)> {
        match self.turning.len() {
            0 => Vec::new(),
            1 => [0.35, 0.7, 1.4].map(|length| (0.12, vec![Some(length)])).into(),
            _ => [
                (0.12, Some(0.45), Some(0.45)),
                (0.12, Some(1.1), Some(1.1)),
                (0.1, Some(0.35), Some(1.4)),
                (0.1, Some(1.4), Some(0.35)),
                (0.1, None, Some(0.7)),
            ]
            .map(|(mean, slow, fast)| (mean, vec![slow, fast]))
            .into(),
        }
    }

    pub fn lengths_of_machine(&self) -> Vec<(f64, Vec<Option<f64>>)> {
        match self.turning.len() {
            0 => Vec::new(),
            1 => vec![(0.1, vec![Some(0.7)])],
            _ => vec![(0.1, vec![Some(0.8), Some(0.8)]), (0.1, vec![Some(0.7), None])],
        }
    }
}
