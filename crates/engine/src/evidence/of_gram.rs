//! What a block of columns says, from its products alone.

use crate::solve::logarithms::log_mean_exp;
use nalgebra::{DMatrix, DVector};

/// Prior sizes of an effect, rms over the readings in units of the white noise: from what is hardly seen to what is obvious.
const SIZES: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Eigenvalues below this share of the largest are rounding of single precision.
const ROUNDING: f64 = 1e-5;

/// What one block of columns says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// ln Bayes factor against nothing, size averaged.
    pub ln_bf: f64,
    /// Half the square that its best size explains: how well it fits, whatever its columns cost.
    pub fit_ln: f64,
}

impl Evidence {
    pub const NOTHING: Self = Self { ln_bf: f64::NEG_INFINITY, fit_ln: 0.0 };
}

/// From AᵀPA, AᵀPy and the white standard deviation.
pub fn evidence_of_gram(gram: &DMatrix<f64>, on_readings: &DVector<f64>, white: f64) -> Evidence {
    let eigen = ((gram + gram.transpose()) * 0.5).symmetric_eigen();
    let z = eigen.eigenvectors.tr_mul(on_readings);
    let largest = eigen.eigenvalues.amax();
    let pairs: Vec<(f64, f64)> = eigen
        .eigenvalues
        .iter()
        .zip(z.iter())
        .filter(|(lambda, _)| **lambda > ROUNDING * largest)
        .map(|(lambda, z)| (*lambda, z * z))
        .collect();
    let at = |size: &f64| {
        let tau = (size * white).powi(2);
        pairs.iter().map(|(l, z)| -0.5 * (tau * l).ln_1p() + 0.5 * tau * z / (1.0 + tau * l)).sum::<f64>()
    };
    let ln_bf = log_mean_exp(&SIZES.iter().map(at).collect::<Vec<_>>());
    Evidence { ln_bf, fit_ln: 0.5 * pairs.iter().map(|(l, z)| z / l).sum::<f64>() }
}
