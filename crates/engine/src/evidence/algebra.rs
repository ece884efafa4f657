//! Small linear algebra of the scans.

use nalgebra::DMatrix;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Threads used for a scan.
const WORKERS: usize = 2;
/// Eigenvalues of a Gram matrix of columns of norm one below this are directions that the columns do not have.
pub const NO_DIRECTION: f64 = 1e-6;
/// Root mean square below which a column is round-off of nothing, mm times the root of a weight.
const NOTHING: f64 = 1e-9;

/// Orthonormal basis of the span of columns of any sizes, by the eigenvectors of the Gram matrix of the scaled columns.
pub fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = columns.clone();
    let least = NOTHING * (columns.nrows() as f64).sqrt();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        if norm > least && norm.is_finite() { column /= norm } else { column.fill(0.0) }
    }
    // Twice: the first round leaves the rounding of the Gram matrix.
    one_round(&one_round(&scaled, NO_DIRECTION), 0.5)
}

fn one_round(columns: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    if columns.ncols() == 0 {
        return columns.clone();
    }
    columns * turn(&(columns.transpose() * columns), least)
}

/// What turns columns of a Gram matrix to be orthonormal; directions with eigenvalues up to `least` are left out.
pub fn turn(gram: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    let eigen = gram.clone().symmetric_eigen();
    let kept: Vec<usize> = (0..eigen.eigenvalues.len()).filter(|&j| eigen.eigenvalues[j] > least).collect();
    let mut turn = eigen.eigenvectors.select_columns(&kept);
    for (mut direction, &j) in turn.column_iter_mut().zip(&kept) {
        direction /= eigen.eigenvalues[j].sqrt();
    }
    turn
}

/// Columns turned to be orthogonal with unit rms over all readings: one prior size then means the same for every effect.
pub fn turned(columns: &DMatrix<f64>) -> DMatrix<f64> {
    orthonormal(columns) * (columns.nrows() as f64).sqrt()
}

/// What an orthonormal basis leaves of columns.
pub fn off(columns: &DMatrix<f64>, basis: &DMatrix<f64>) -> DMatrix<f64> {
    columns - basis * basis.tr_mul(columns)
}

/// Two sets of columns side by side.
pub fn joined(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = first.clone().resize_horizontally(first.ncols() + second.ncols(), 0.0);
    all.columns_mut(first.ncols(), second.ncols()).copy_from(second);
    all
}

/// `f(0..count)` on a few threads, results in order. Each takes the next one that is left: some take several times as long as others.
pub fn parallel<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let taken = AtomicUsize::new(0);
    let work = || {
        let next = std::iter::repeat_with(|| taken.fetch_add(1, Ordering::Relaxed));
        next.take_while(|&i| i < count).map(|i| (i, f(i))).collect::<Vec<_>>()
    };
    let mut done: Vec<(usize, T)> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..count.min(WORKERS)).map(|_| scope.spawn(work)).collect();
        handles.into_iter().flat_map(|h| h.join().expect("a worker panics only on a defect")).collect()
    });
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, value)| value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of a badly scaled polynomial, one of them twice, one that moves nothing.
    #[test]
    fn the_basis_is_orthonormal_and_spans_the_columns() {
        let at = |i: usize| i as f64 / 40.0;
        let columns = DMatrix::from_fn(40, 6, |i, j| match j {
            5 => 0.0,
            _ => 1e3_f64.powi(j as i32) * at(i).powi(j.min(3) as i32),
        });
        let basis = orthonormal(&columns);
        assert_eq!(basis.ncols(), 4);
        assert!((basis.tr_mul(&basis) - DMatrix::identity(4, 4)).amax() < 1e-9);
        for column in columns.column_iter() {
            let left = column - &basis * basis.tr_mul(&column);
            assert!(left.norm() <= 1e-6 * column.norm());
        }
    }
}
