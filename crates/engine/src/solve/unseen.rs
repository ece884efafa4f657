//! Directions that a design shows no more than positions a little off would.

use crate::solve::linear::Reduced;
use nalgebra::DMatrix;

/// Orthonormal rows v with ‖R v‖² ≤ vᵀ (ΔAᵀΔA + ε²) v: with ΔAᵀΔA + ε² = T⁻ᵀ T⁻¹ the v = T w, w the right singular vectors of R T whose
/// singular values are at most 1.
pub(crate) fn unseen(triangle: &DMatrix<f64>, off: DMatrix<f64>, floor: f64) -> DMatrix<f64> {
    let width = triangle.ncols();
    let eigen = off.symmetric_eigen();
    let little =
        eigen.eigenvalues.map(|square| (square.max(0.0) + floor * floor).max(f64::MIN_POSITIVE).sqrt());
    let scaled = eigen.eigenvectors * DMatrix::from_diagonal(&little.map(f64::recip));
    let (gamma, w_t) = Reduced::singular_of(triangle * &scaled);
    let below: Vec<usize> = (0..gamma.len()).filter(|&i| gamma[i] <= 1.0).collect();
    if below.is_empty() {
        return DMatrix::zeros(0, width);
    }
    (scaled * w_t.select_rows(&below).transpose()).qr().q().transpose()
}
