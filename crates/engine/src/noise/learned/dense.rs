//! Inverse and determinant of a large positive definite matrix in blocks, so that nearly all of it is matrix products.

use nalgebra::{DMatrix, DMatrixView, RealField};

/// Rows of a block: a block and its neighbours stay in the second-level cache.
const BLOCK: usize = 96;

/// ln det and inverse of a matrix of which the lower triangle is given; `None` where it is not positive definite.
pub(super) fn inverse<T: RealField + Copy>(mut a: DMatrix<T>) -> Option<(f64, DMatrix<T>)> {
    let n = a.nrows();
    let blocks: Vec<(usize, usize)> =
        (0..n).step_by(BLOCK).map(|from| (from, (from + BLOCK).min(n) - from)).collect();
    let (log_det, diagonals) = factor(&mut a, &blocks)?;
    let lower = inverse_of_lower(&a, &diagonals, &blocks);
    // L⁻ᵀ L⁻¹, block row by block row of the lower triangle.
    let upper = lower.transpose();
    let mut inverse = a;
    for &(i, rows) in &blocks {
        let left = upper.view((i, i), (rows, n - i));
        let right = lower.view((i, 0), (n - i, i + rows));
        inverse.view_mut((i, 0), (rows, i + rows)).gemm(T::one(), &left, &right, T::zero());
    }
    inverse.fill_upper_triangle_with_lower_triangle();
    Some((log_det, inverse))
}

/// The Cholesky factor in place of the lower triangle; ln det and the inverses of the diagonal blocks of the factor.
fn factor<T: RealField + Copy>(
    a: &mut DMatrix<T>,
    blocks: &[(usize, usize)],
) -> Option<(f64, Vec<DMatrix<T>>)> {
    let n = a.nrows();
    let (mut log_det, mut diagonals) = (0.0, Vec::with_capacity(blocks.len()));
    for (b, &(k, size)) in blocks.iter().enumerate() {
        let of_block = a.view((k, k), (size, size)).into_owned().cholesky()?.unpack();
        for value in of_block.diagonal().iter() {
            log_det += 2.0 * number(*value).ln();
        }
        let inverse = of_block.solve_lower_triangular(&DMatrix::identity(size, size))?;
        a.view_mut((k, k), (size, size)).copy_from(&of_block);
        let below = k + size;
        if below < n {
            let panel = a.view((below, k), (n - below, size)) * inverse.transpose();
            let across = panel.transpose();
            a.view_mut((below, k), (n - below, size)).copy_from(&panel);
            for &(j, width) in &blocks[b + 1..] {
                let left = panel.rows(j - below, n - j);
                let right = across.columns(j - below, width);
                a.view_mut((j, j), (n - j, width)).gemm(-T::one(), &left, &right, T::one());
            }
        }
        diagonals.push(inverse);
    }
    log_det.is_finite().then_some((log_det, diagonals))
}

fn inverse_of_lower<T: RealField + Copy>(
    factor: &DMatrix<T>,
    diagonals: &[DMatrix<T>],
    blocks: &[(usize, usize)],
) -> DMatrix<T> {
    let mut inverse: DMatrix<T> = DMatrix::zeros(factor.nrows(), factor.nrows());
    for (b, &(i, rows)) in blocks.iter().enumerate() {
        for &(j, width) in &blocks[..b] {
            let left: DMatrixView<'_, T> = factor.view((i, j), (rows, i - j));
            let sum = left * inverse.view((j, j), (i - j, width));
            inverse.view_mut((i, j), (rows, width)).gemm(-T::one(), &diagonals[b], &sum, T::zero());
        }
        inverse.view_mut((i, i), (rows, rows)).copy_from(&diagonals[b]);
    }
    inverse
}

fn number<T: RealField + Copy>(value: T) -> f64 {
    value.to_subset().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// More than two blocks, the last one short.
    #[test]
    fn inverse_and_determinant_agree_with_the_plain_ones() {
        let n = 2 * BLOCK + 7;
        let root = DMatrix::from_fn(n, n, |i, j| ((i * 37 + j * 11 + i * j) % 23) as f64 / 23.0 - 0.5);
        let a = &root * root.transpose() + DMatrix::identity(n, n);
        let (log_det, found) = inverse(a.clone()).unwrap();
        assert!((&a * &found - DMatrix::identity(n, n)).amax() < 1e-9);
        let plain: f64 = a.clone().symmetric_eigenvalues().iter().map(|x| x.ln()).sum();
        assert!((log_det - plain).abs() < 1e-8, "{log_det} {plain}");
        assert!(inverse(a - DMatrix::identity(n, n) * 2.0).is_none());
    }
}
