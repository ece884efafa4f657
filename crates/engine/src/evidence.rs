//! Evidence of columns against nothing at one covariance of the noise (docs/design/statistics.md §2).
//!
//! Columns of a block are turned to be orthogonal with unit rms over the readings; β ~ N(0, τ²I), τ/s averaged over eight doublings.
//! With G = AᵀPA = E Λ Eᵀ and z = EᵀAᵀPy:
//!
//! ln B(τ) = −½ Σ ln(1 + τ²λ_i) + ½ Σ τ² z_i² / (1 + τ²λ_i)
//!
//! P has the columns of the model projected out: a direction that the model imitates has λ ≈ 0 and adds nothing.

mod algebra;
mod of_some;

pub use algebra::{joined, log_mean_exp, orthonormal, parallel, turned};
pub use of_some::of_some_ln;

use crate::noise::learned::Real;
use crate::noise::learned::sigma::Projected;
use algebra::{NO_DIRECTION, turn};
use nalgebra::{DMatrix, DVector};

/// Prior sizes of an effect, rms over the readings in units of the white noise: from what is hardly seen to what is obvious.
const SIZES: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Eigenvalues below this share of the largest are rounding of single precision.
const ROUNDING: f64 = 1e-5;

/// What one block of columns says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weighed {
    /// ln Bayes factor against nothing, size averaged.
    pub ln_bf: f64,
    /// Half the square that its best size explains: how well it fits, whatever its columns cost.
    pub fit_ln: f64,
}

impl Weighed {
    pub const NOTHING: Self = Self { ln_bf: f64::NEG_INFINITY, fit_ln: 0.0 };
}

/// From AᵀPA, AᵀPy and the white standard deviation.
pub fn weighed(gram: &DMatrix<f64>, on_readings: &DVector<f64>, white: f64) -> Weighed {
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
    Weighed { ln_bf, fit_ln: 0.5 * pairs.iter().map(|(l, z)| z / l).sum::<f64>() }
}

/// Blocks of turned columns side by side, each of its width.
pub fn weigh_all(here: &Projected, columns: &DMatrix<Real>, widths: &[usize]) -> Vec<Weighed> {
    weigh_grams(here, columns, &here.grams(columns, widths))
}

/// The same where AᵀPA of the blocks is known.
pub fn weigh_grams(here: &Projected, columns: &DMatrix<Real>, grams: &[DMatrix<f64>]) -> Vec<Weighed> {
    let on_readings = columns.tr_mul(&here.py).cast::<f64>();
    let white = here.sigma.x[0].exp();
    let mut first = 0;
    let of_block = |gram: &DMatrix<f64>| {
        let of_block = on_readings.rows(first, gram.ncols()).into_owned();
        first += gram.ncols();
        if gram.is_empty() { Weighed::NOTHING } else { weighed(gram, &of_block, white) }
    };
    grams.iter().map(of_block).collect()
}

/// One block of turned columns.
pub fn weigh(here: &Projected, columns: &DMatrix<f64>) -> Weighed {
    weigh_all(here, &columns.map(|x| x as Real), &[columns.ncols()])[0]
}
