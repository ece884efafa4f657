//! Covariance from what no reading shows to first order, though it acts in second: the tilt of a laser beam.
//!
//! l(ε) = l + l′ε + ½ l″ε²,  ε ~ N(0, σ²):   C = Σ_ε H (σ² l′l′ᵀ + ½ σ⁴ l″l″ᵀ) Hᵀ + d dᵀ,   d = H Σ_ε ½ σ² l″       [GUM F.2.4.4]
//!
//! l: readings of the fitted machine; l′, l″: by differences over ± σ; H: from readings to parameters; σ: known beforehand, from the
//! instrument or from a prior of the model. d is what the squares make on average, a correction that is known and not made
//! [GUM F.2.4.5]. The two tilts ε₁, ε₂ of a beam before a mirror that was found off by m₁, m₂
//! scale its line by −m₁ε₁ − m₂ε₂ + ½(ε₁² + ε₂²): σ √(m² + σ²) about its mean σ², which d holds.
//! Limits: products of two such tilts of one beam are left out, they are of the fourth order; the tilts of two setups are independent.

use crate::fit::gauss_newton::Converged;
use crate::problem::design::Design;
use crate::problem::side_by_side::SideBySide;
use crate::solve::direction::Status;
use nalgebra::{DMatrix, DVector};

/// Of the determined parameters; `None` where the model has no such unknown.
pub(crate) fn second_order(design: &Design<'_>, fit: &Converged, used: &[bool]) -> Option<DMatrix<f64>> {
    let unknown: Vec<(usize, f64)> =
        (0..design.joint.width()).filter_map(|j| Some((j, u_beforehand(design.joint, fit, j)?))).collect();
    if unknown.is_empty() || fit.datum.determined.is_empty() {
        return None;
    }
    let of_readings = |mut change_mm: DVector<f64>| {
        change_mm.component_mul_assign(&design.weights.root);
        design.experiment.unused_rows(used).for_each(|row| change_mm[row] = 0.0);
        change_mm
    };
    let mut changes = DMatrix::zeros(design.experiment.rows(), 2 * unknown.len());
    for (k, &(j, sigma)) in unknown.iter().enumerate() {
        let off_by = |amount: f64| {
            let mut solution = fit.solution.clone();
            solution[j] += amount;
            design.joint.predict_mm(design.experiment, &solution)
        };
        let (more, less) = (off_by(sigma), off_by(-sigma));
        changes.set_column(2 * k, &of_readings((&more - &less) * 0.5));
        changes.set_column(2 * k + 1, &of_readings(more + less - &fit.predicted_mm * 2.0));
    }
    let of_parameters = fit.solver.cofactor() * design.on_columns(&fit.datum.determined, &changes);
    let mut mean = DVector::zeros(of_parameters.nrows());
    let mut covariance = DMatrix::zeros(mean.len(), mean.len());
    for k in 0..unknown.len() {
        let (first, second) = (of_parameters.column(2 * k), of_parameters.column(2 * k + 1));
        covariance += first * first.transpose() + second * second.transpose() * 0.5;
        mean += second * 0.5;
    }
    Some(covariance + &mean * mean.transpose())
}

/// σ of a parameter that the readings do not determine.
pub(crate) fn u_beforehand(joint: &SideBySide, fit: &Converged, j: usize) -> Option<f64> {
    let of_instrument = joint.parameters[j].u_beforehand?;
    let prior = joint.priors.iter().find(|prior| prior.parameter == j);
    match (fit.datum.status[j], prior) {
        (Status::Identified | Status::Unobservable, Some(prior)) => Some(prior.u),
        (Status::Unobservable, None) => Some(of_instrument),
        _ => None,
    }
}
