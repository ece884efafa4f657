//! How the list is fitted, for the fit and for what is confounded with it.

use crate::common::rounding::ROUNDING_MM;
use nalgebra::{DVector, DVectorView};

/// Relative singular value below which errors are not distinguished.
pub(super) const TOLERANCE: f64 = 1e-6;
/// Columns of the centring: 1, cos φ, sin φ.
pub(super) const CENTRING: usize = 3;

/// An error below this makes nothing but rounding of any reading; `column`: what one of it makes of them, mm.
pub(super) fn rounding(column: DVectorView<'_, f64>) -> f64 {
    ROUNDING_MM / column.amax()
}

/// How much wider uncertainties are than of white noise: root of the integrated autocorrelation of what is left, up to where it
/// first falls into the noise (Sokal 1989). One for white noise.
pub(super) fn widened(left: &DVector<f64>) -> f64 {
    let (n, all) = (left.len(), left.norm_squared().max(f64::MIN_POSITIVE));
    let correlation = |lag: usize| left.rows(lag, n - lag).dot(&left.rows(0, n - lag)) / all;
    let in_noise = 2.0 / (n as f64).sqrt();
    let correlated: f64 = (1..n / 4).map(correlation).take_while(|rho| *rho > in_noise).sum();
    (1.0 + 2.0 * correlated).sqrt()
}
