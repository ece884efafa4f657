//! Small linear algebra of the scans.

use super::SURVIVAL;
use nalgebra::DMatrix;
use std::ops::Range;

/// Threads used for the bank.
const WORKERS: usize = 2;

/// Eigenvalues of a Gram matrix below this share of the largest are directions that the columns do not have.
const NO_DIRECTION: f64 = 1e-12;

/// Orthonormal basis of columns of similar size and ln det of their Gram matrix over the directions kept. By the eigenvectors of the
/// Gram matrix, made orthonormal once more by a Cholesky factor: as exact as a decomposition of the columns, in a tenth of the time.
pub(super) fn orthonormal(columns: &DMatrix<f64>) -> (DMatrix<f64>, f64) {
    if columns.ncols() == 0 {
        return (DMatrix::zeros(columns.nrows(), 0), 0.0);
    }
    let eigen = columns.tr_mul(columns).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> =
        (0..eigen.eigenvalues.len()).filter(|&j| eigen.eigenvalues[j] > NO_DIRECTION * largest).collect();
    let mut turn = eigen.eigenvectors.select_columns(&kept);
    for (mut direction, &j) in turn.column_iter_mut().zip(&kept) {
        direction /= eigen.eigenvalues[j].sqrt();
    }
    let rough = columns * turn;
    let factor = rough.tr_mul(&rough).cholesky().expect("nearly the identity").unpack();
    let log_det = kept.iter().map(|&j| eigen.eigenvalues[j].ln()).sum::<f64>()
        + 2.0 * factor.diagonal().map(f64::ln).sum();
    let mut basis = rough.transpose();
    let solved = factor.solve_lower_triangular_mut(&mut basis);
    debug_assert!(solved, "a Cholesky factor has a positive diagonal");
    (basis.transpose(), log_det)
}

/// Orthonormal basis of what is left of `raw` columns (column × row), dropping directions that hardly survive.
pub(super) fn surviving_basis(left: &DMatrix<f64>, raw: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = left.clone();
    for (j, scale) in column_scales(raw).into_iter().enumerate() {
        scaled.column_mut(j).unscale_mut(scale);
    }
    let svd = scaled.svd(true, false);
    let left = svd.u.expect("asked for");
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&j| svd.singular_values[j] > SURVIVAL).collect();
    DMatrix::from_fn(left.nrows(), kept.len(), |i, k| left[(i, kept[k])])
}

/// Norm of each column (column × row); infinite for one that moves nothing, so that it scales to zero and
/// never to a number that no decomposition survives.
pub(super) fn column_scales(columns: &DMatrix<f64>) -> Vec<f64> {
    let norms: Vec<f64> = (0..columns.nrows()).map(|j| columns.row(j).norm()).collect();
    let largest = norms.iter().copied().fold(0.0, f64::max);
    norms.into_iter().map(|norm| if norm > 1e-12 * largest { norm } else { f64::INFINITY }).collect()
}

/// Two sets of columns (column × row) in one.
pub fn stacked(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(first.nrows() + second.nrows(), first.ncols());
    all.rows_mut(0, first.nrows()).copy_from(first);
    all.rows_mut(first.nrows(), second.nrows()).copy_from(second);
    all
}

/// ln Σ exp.
pub(super) fn log_sum_exp(terms: impl Iterator<Item = f64> + Clone) -> f64 {
    let largest = terms.clone().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return largest;
    }
    largest + terms.map(|x| (x - largest).exp()).sum::<f64>().ln()
}

/// `f(0..count)` on a few threads, results in order.
pub fn parallel<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let share = count.div_ceil(WORKERS).max(1);
    let chunks: Vec<Range<usize>> =
        (0..count).step_by(share).map(|from| from..(from + share).min(count)).collect();
    std::thread::scope(|scope| {
        let handles: Vec<_> =
            chunks.into_iter().map(|chunk| scope.spawn(|| chunk.map(&f).collect::<Vec<_>>())).collect();
        handles.into_iter().flat_map(|h| h.join().expect("a worker panics only on a defect")).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a badly scaled polynomial, one of them twice.
    #[test]
    fn the_basis_is_orthonormal_spans_the_columns_and_knows_their_determinant() {
        let at = |i: usize| i as f64 / 40.0;
        let columns = DMatrix::from_fn(40, 7, |i, j| at(i).powi(j.min(5) as i32));
        let (basis, log_det) = orthonormal(&columns);
        assert_eq!(basis.ncols(), 6);
        assert!((basis.tr_mul(&basis) - DMatrix::identity(6, 6)).amax() < 1e-12);
        assert!((&columns - &basis * basis.tr_mul(&columns)).amax() < 1e-8);
        let singular = columns.singular_values();
        let expected: f64 = singular.iter().take(6).map(|s| 2.0 * s.ln()).sum();
        assert!((log_det - expected).abs() < 1e-6, "{log_det} {expected}");
    }

    /// Forward wobble at one lobe is zero by definition; its scaled Gram matrix once was NaN, and the
    /// decomposition of that never ended.
    #[test]
    fn a_column_that_moves_nothing_scales_to_zero() {
        let columns = DMatrix::from_row_slice(3, 2, &[3.0, 4.0, 0.0, 0.0, 1e-17, 0.0]);
        let scales = column_scales(&columns);
        assert_eq!(scales, [5.0, f64::INFINITY, f64::INFINITY]);
        let basis = surviving_basis(&columns.transpose(), &columns);
        assert_eq!(basis.ncols(), 1);
    }
}
