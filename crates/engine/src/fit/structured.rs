//! Covariance of the parameters under noise as machines make it.
//!
//! The estimate was x̂ = H r, H = (AᵀA + P)⁻¹ Aᵀ with weighted rows A and the priors P of the model. Whatever Σ is, its covariance is
//! the sandwich H Σ Hᵀ:
//!
//! C = N (σ_w² AᵀA + Σ_k v_k (AᵀZ_k)(AᵀZ_k)ᵀ + v_L AᵀL LᵀA + Π) N,   N = (AᵀA + P)⁻¹
//!
//! σ_w², v_k, v_L from [`crate::noise::variances`]; Z_k, L from [`crate::noise::random_columns`], multiplied by the same weights ω as the readings (the
//! white part of Σ is then diag(σ_w²/ω²)); Π: the u² of the priors. Structure is counted once: the white variance is what
//! the structure leaves.
//! Limits: readings at rest. On the fly neighbours err alike for more reasons than these; long runs cost too much; with few
//! readings there is no saying what is noise. There the clusters of [`crate::fit::uncertainty`] serve.

use crate::fit::gauss_newton::Converged;
use crate::fit::identification::NoisePart;
use crate::noise::likelihood::Residual;
use crate::noise::machine_noise::Order;
use crate::noise::random_columns::{Levers, kinds};
use crate::noise::variances::variances;
use crate::problem::design::Design;
use crate::problem::passes::Passes;
use nalgebra::DMatrix;
use trunnion_cycles::RunKind;

const MOST_ROWS: usize = 20_000;
const MOST_COLUMNS: usize = 600;
const FEWEST_DEGREES_OF_FREEDOM: usize = 20;

/// Covariance of the determined parameters and the parts of the noise behind it; `None` outside the limits.
pub(crate) fn structured(
    design: &Design<'_>,
    passes: &Passes,
    fit: &Converged,
    used: &[bool],
) -> Option<(DMatrix<f64>, Vec<NoisePart>)> {
    let experiment = design.experiment;
    if experiment.kinds.contains(&RunKind::OnTheFly)
        || experiment.rows() > MOST_ROWS
        || fit.degrees_of_freedom() < FEWEST_DEGREES_OF_FREEDOM
        || fit.datum.determined.is_empty()
    {
        return None;
    }
    let mut root = design.weights.root.clone();
    let mut residual_mm = fit.weighted_mm.clone();
    let mut fitted = DMatrix::zeros(experiment.rows(), fit.datum.determined.len());
    design.blocks(&mut |_, rows, columns| {
        let chosen = columns.select_columns(&fit.datum.determined);
        fitted.rows_mut(rows.start, rows.len()).copy_from(&chosen);
    });
    for row in crate::problem::design::unused_rows(experiment, used) {
        (root[row], residual_mm[row]) = (0.0, 0.0);
        fitted.row_mut(row).fill(0.0);
    }
    let order = Order::new(experiment);
    let kinds = kinds(experiment, &order, passes, &root);
    if kinds.iter().map(|kind| kind.columns.ncols()).sum::<usize>() > MOST_COLUMNS {
        return None;
    }
    let levers = Levers::new(&order, &root);
    let found = variances(&Residual {
        fitted: &fitted,
        residual_mm: &residual_mm,
        kinds: &kinds,
        levers: &levers,
        degrees_of_freedom: fit.degrees_of_freedom(),
    });

    let mut noise_of_scores = fitted.tr_mul(&fitted) * found.white + prior_scores(design, fit);
    let mut parts = vec![NoisePart { name: "white", sigma_mm: found.white.sqrt() }];
    for (kind, &variance) in kinds.iter().zip(&found.kinds) {
        let score = fitted.tr_mul(&kind.columns);
        noise_of_scores += &score * score.transpose() * variance;
        parts.push(NoisePart { name: kind.name, sigma_mm: variance.sqrt() });
    }
    if !levers.is_empty() {
        let score = levers.seen_by(&fitted);
        noise_of_scores += score.tr_mul(&score) * found.levers;
        parts.push(NoisePart { name: Levers::NAME, sigma_mm: found.levers.sqrt() });
    }
    let cofactor = fit.solver.cofactor();
    let covariance = &cofactor * noise_of_scores * &cofactor;
    Some(((&covariance + covariance.transpose()) * 0.5, parts))
}

/// Π: a prior enters as a reading w x = w x₀ that errs by w u.
fn prior_scores(design: &Design<'_>, fit: &Converged) -> DMatrix<f64> {
    let determined = &fit.datum.determined;
    let mut scores = DMatrix::zeros(determined.len(), determined.len());
    for (prior, weight) in design.joint.priors.iter().zip(&fit.prior_weights) {
        if let Some(k) = determined.iter().position(|j| *j == prior.parameter) {
            scores[(k, k)] += (weight * weight * prior.u).powi(2);
        }
    }
    scores
}
