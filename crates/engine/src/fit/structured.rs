//! Covariance of the parameters under the noise that the run itself shows.
//!
//! The estimate was x̂ = H r, H = (AᵀA + P)⁻¹ Aᵀ with weighted rows A and the priors P of the model. What the noise makes of numbers that are
//! linear in the readings is that of [`crate::fit::reading_noise`], here with h_i = N a_i:
//!
//! C = N (Σ_i s²W_i q_i a_i a_iᵀ + Σ_k v_k AᵀK_kA + Π) N + δδᵀ,   N = (AᵀA + P)⁻¹
//!
//! A: the columns of the determined parameters, and of the shape numbers that the fit found ([`crate::fit::sensitivity`]). Π:
//! the u² of the priors. a_i: rows of A.
//! Limits: outside those of the noise the clusters of [`crate::fit::uncertainty`] serve.

use crate::fit::gauss_newton::Converged;
use crate::fit::identification::NoisePart;
use crate::fit::reading_noise::{BeyondModel, Columns, ReadingNoise, on_nodes};
use crate::fit::sensitivity::Sensitivity;
use crate::noise::learned::remainder::{Fitted, Learned};
use crate::problem::design::Visit;
use crate::problem::rows::Rows;
use nalgebra::DMatrix;
use std::convert::Infallible;

/// What the learned noise says of a fit.
pub(crate) struct Structured {
    /// Of the determined parameters and the shape numbers that the fit found.
    pub covariance: DMatrix<f64>,
    pub parts: Vec<NoisePart>,
    pub noise: Learned,
}

/// `None` outside the limits. `other`: the noise of another fit of the same points.
pub(crate) fn structured(
    known: &Sensitivity<'_, '_>,
    fit: &Converged,
    used: &[bool],
    other: Option<&Learned>,
) -> Option<Structured> {
    if known.width() == 0 {
        return None;
    }
    let design = known.design;
    let fitted = Fitted {
        row_weights: &design.weights.root,
        residual_mm: &fit.residual_mm,
        predicted_mm: &fit.predicted_mm,
        used,
        own: None,
        other,
    };
    let blocks = |visit: Visit<'_>| known.blocks(visit);
    let columns = Columns { width: known.width(), blocks: &blocks };
    let means = |rows: &Rows<'_>, _: &_| Ok::<_, Infallible>(means(known, &columns, rows));
    let Ok(noise) = ReadingNoise::learn(design.experiment, &fitted, fit.degrees_of_freedom(), means);
    let noise = noise?;
    let covariance =
        noise.covariance(&columns, &known.cofactor, &prior_scores(known, fit), BeyondModel::NOTHING);
    Some(Structured { covariance, parts: noise.parts(), noise: noise.learned })
}

/// The columns on the rows that are looked at, weighted.
fn means(known: &Sensitivity<'_, '_>, columns: &Columns<'_>, rows: &Rows<'_>) -> DMatrix<f64> {
    let mut shares = vec![0.0; known.design.experiment.points.len()];
    for node in 0..rows.points.points.len() {
        let points = rows.points_of(node);
        points.iter().for_each(|&point| shares[point] = 1.0 / points.len() as f64);
    }
    on_nodes(known.design.experiment, columns, rows, |point| shares[point])
}

/// Π: a prior enters as a reading w x = w x₀ that errs by w u.
fn prior_scores(known: &Sensitivity<'_, '_>, fit: &Converged) -> DMatrix<f64> {
    let determined = &fit.datum.determined;
    let of_model = known.design.joint.priors.iter().zip(&fit.prior_weights);
    let of_model = of_model.filter_map(|(prior, weight)| {
        Some((determined.iter().position(|j| *j == prior.parameter)?, *weight, prior.u))
    });
    let of_numbers = known.numbers.iter().enumerate();
    let of_numbers = of_numbers.map(|(k, number)| (determined.len() + k, number.weight, number.u_beforehand));
    let mut scores = DMatrix::zeros(known.width(), known.width());
    for (k, weight, u) in of_model.chain(of_numbers) {
        scores[(k, k)] += (weight * weight * u).powi(2);
    }
    scores
}
