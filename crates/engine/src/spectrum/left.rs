//! What the model of a problem leaves, as every spectrum of it needs it.

use super::shapes::{Found, at_rest, carriers, found};
use super::wave::Waves;
use crate::problem::Problem;
use crate::problem::credible::credible_columns;
use crate::problem::poses::count;
use crate::solve::linear::Reduced;
use crate::{Experiment, IdentifyError};
use nalgebra::{DMatrix, DVector};
use trunnion_core::Joint;
use trunnion_effects::{Instance, Shapes, WaveNumber};

/// Points of which a spectrum is formed; of more, as many are drawn, never every k-th: a regular choice would alias.
const MOST_POINTS: usize = 6_000;
/// Relative singular value of a direction that the columns do not see.
const UNSEEN: f64 = 1e-6;

/// The residual of the points that count.
#[derive(Clone, Debug)]
pub(crate) struct Left {
    pub experiment: Experiment,
    /// Orthonormal columns of the model, rows × rank.
    pub basis: DMatrix<f64>,
    /// mm, orthogonal to `basis`.
    pub residual_mm: DVector<f64>,
}

impl Left {
    /// # Errors
    /// A model whose columns cannot be formed.
    pub fn of(problem: &Problem<'_>) -> Result<Self, IdentifyError> {
        let (experiment, fit) = (problem.experiment(), problem.fit());
        let drawn = drawn(experiment.points.len());
        let keep: Vec<bool> = drawn.iter().zip(&fit.used).map(|(drawn, used)| *drawn && *used).collect();
        let kept = (0..keep.len()).filter(|&i| keep[i]);
        let rows: Vec<usize> = kept.flat_map(|i| experiment.rows_of(i)).collect();
        let experiment = experiment.kept(&keep);
        let columns = problem.columns(&experiment)?;
        let seen = Reduced::from_design(&columns).orthonormal(UNSEEN);
        let basis = columns * seen;
        let mut residual_mm = fit.residual_mm.select_rows(&rows);
        let on_basis = basis.tr_mul(&residual_mm);
        residual_mm -= &basis * on_basis;
        Ok(Self { experiment, basis, residual_mm })
    }

    /// What the residual shows of an effect that waves.
    pub fn found(&self, instance: &Instance, shapes: &Shapes) -> Option<Found> {
        found(shapes.wave?, &self.waves(instance, shapes.wave?))
    }

    /// What may wave of an effect.
    pub fn waves(&self, instance: &Instance, repeats: WaveNumber) -> Waves {
        let columns = credible_columns(&self.experiment, instance, &at_rest(repeats));
        let (basis, residual_mm) = (self.basis.clone(), self.residual_mm.clone());
        Waves::new(self.experiment.positions(repeats.joint()), carriers(&columns), basis, residual_mm)
    }

    /// How many positions of an axis differ.
    pub fn distinct_positions(&self, joint: Joint) -> usize {
        count(&self.experiment.stands(&[joint]))
    }
}

/// Points that take part: all, or [`MOST_POINTS`] drawn without a pattern (multiplicative hashing, Knuth vol. 3 §6.4).
fn drawn(points: usize) -> Vec<bool> {
    let share = MOST_POINTS as f64 / points.max(1) as f64;
    let chance = |i: usize| {
        let mixed = (i as u64 ^ 0x5DEE_CE66).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) as f64 / u64::MAX as f64
    };
    (0..points).map(|i| share >= 1.0 || chance(i) < share).collect()
}
