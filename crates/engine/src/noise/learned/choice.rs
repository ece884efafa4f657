//! A choice of parts of the noise that a machine has, at its mode.

use super::size::Density;
use crate::solve::normal::below;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// A choice of parts at its mode.
pub(super) struct Choice {
    pub kernels: Vec<usize>,
    /// x̂: ln ρ of those less ln ρ̂ of all kernels together.
    pub x: DVector<f64>,
    pub densities: Vec<Density>,
    /// R = L Lᵀ: L, and ½ ln|R|.
    pub root: DMatrix<f64>,
    pub ln_root: f64,
    /// ln p(z | c), but for a constant.
    pub ln_evidence: f64,
}

impl Choice {
    /// Sizes at normal deviates, and ln of dx/dζ with √2π to their number.
    pub fn at(&self, deviates: &DVector<f64>) -> (DVector<f64>, f64) {
        let mut ln_volume = 0.0;
        let x = DVector::from_fn(deviates.len(), |k, _| {
            let (off, density) = self.densities[k].quantile(below(deviates[k]));
            ln_volume -= density.ln() + 0.5 * deviates[k].powi(2) + 0.5 * (2.0 * PI).ln();
            self.x[k] + off
        });
        (x, ln_volume)
    }
}
