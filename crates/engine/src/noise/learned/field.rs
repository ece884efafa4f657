//! A smooth pattern over the rotary axes that comes back: in which axes, and over which lengths.

use super::Real;
use crate::Experiment;
use crate::problem::taken::Taken;
use nalgebra::DMatrix;
use trunnion_core::Joint;

/// A rotary axis that covers this much is taken as closed, rad.
const CLOSED_RAD: f64 = 5.2;

/// The rotary axes over which a pattern may repeat. On linear axes a smooth pattern is a component error, which has a name.
pub(super) struct Axes {
    /// Positions of each point, rad, and whether the axis closes; slow axis first.
    pub turning: Vec<(Vec<f64>, bool)>,
}

impl Axes {
    pub fn new(experiment: &Experiment, taken: &Taken) -> Self {
        let positions = |letter: Joint| {
            let of_points: Vec<f64> =
                experiment.points.iter().map(|point| point.state.position[letter]).collect();
            let (low, high) = experiment.scene.position_range[letter];
            (of_points, high - low > CLOSED_RAD)
        };
        Self { turning: [taken.slow, taken.fast].into_iter().flatten().map(positions).collect() }
    }

    /// exp(−½ Σ (d/ℓ)²); d a chord on an axis that closes; no length: alike along that axis.
    pub fn field(&self, lengths: &[Option<f64>]) -> DMatrix<Real> {
        let points = self.turning.first().map_or(0, |(positions, _)| positions.len());
        DMatrix::from_fn(points, points, |i, j| {
            let of_axis = |((positions, closes), length): (&(Vec<f64>, bool), &Option<f64>)| {
                let Some(length) = length else { return 0.0 };
                let turn = positions[i] - positions[j];
                let distance = if *closes { 2.0 * (0.5 * turn).sin() } else { turn };
                (distance / length).powi(2)
            };
            (-0.5 * self.turning.iter().zip(lengths).map(of_axis).sum::<f64>()).exp() as Real
        })
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
