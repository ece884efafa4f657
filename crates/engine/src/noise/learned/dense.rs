//! Inverse and determinant of a large positive definite matrix by halves, so that nearly all of it is products of large matrices.
//!
//! A = LLᵀ, R = L⁻ᵀ, A⁻¹ = RRᵀ, with halves 1 and 2:
//! L₂₁ = A₂₁L₁₁⁻ᵀ,   L₂₂L₂₂ᵀ = A₂₂ − L₂₁L₂₁ᵀ,   R₁₂ = −R₁₁L₂₁ᵀR₂₂,   (RRᵀ)₁₁ = R₁₁R₁₁ᵀ + R₁₂R₁₂ᵀ,   (RRᵀ)₂₁ = R₂₂R₁₂ᵀ
//!
//! Where it can be chosen, a product has its second factor transposed: `matrixmultiply` copies that one fast, any other element by element.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, Dyn, RealField};
use std::ops::Range;

/// A block up to this size is factored element by element.
const SMALL: usize = 48;
/// Products with a triangle leave its zeros out in strips of this width; narrower ones cost more in copies than they save.
const STRIP: usize = 64;
/// Side of the squares that are mirrored.
const TILE: usize = 32;

/// ln det of a matrix of which the lower triangle is given, with L in place of that; `None` where it is not positive definite.
pub(super) fn factor<T: RealField + Copy>(a: &mut DMatrix<T>) -> Option<f64> {
    let rows = 0..a.nrows();
    factor_block(a, rows, &mut Vec::new()).filter(|log_det| log_det.is_finite())
}

/// A⁻¹ in place of L.
pub(super) fn inverse<T: RealField + Copy>(mut root: DMatrix<T>) -> Option<DMatrix<T>> {
    let n = root.nrows();
    let mut product = vec![T::zero(); n.div_ceil(2).pow(2)];
    invert(&mut root, 0..n, &mut product)?;
    square(&mut root, 0..n);
    mirror(&mut root);
    Some(root)
}

/// L in place of the lower triangle of a block on the diagonal; ln det of the block. `inverses`: of the small blocks of L so far, each
/// with its first row.
fn factor_block<T: RealField + Copy>(
    a: &mut DMatrix<T>,
    block: Range<usize>,
    inverses: &mut Vec<(usize, DMatrix<T>)>,
) -> Option<f64> {
    let Some([first, second]) = halves(&block) else {
        let mut of_block = a.view_mut((block.start, block.start), (block.len(), block.len()));
        let small = of_block.clone_owned().cholesky()?.unpack();
        of_block.copy_from(&small);
        inverses.push((block.start, inverse_of_small(&small)?));
        return Some(small.diagonal().iter().map(|value| 2.0 * number(*value).ln()).sum());
    };
    let log_det = factor_block(a, first.clone(), inverses)?;
    solve(a, &second, first.clone(), inverses);
    let n = a.nrows();
    let (left, right) = a.as_mut_slice().split_at_mut(second.start * n);
    for strip in strips(&second) {
        let below = view(left, n, strip.start..second.end, first.clone());
        let across = transposed(left, n, strip.clone(), first.clone());
        let columns = strip.start - second.start..strip.end - second.start;
        view_mut(right, n, strip.start..second.end, columns).gemm(-T::one(), &below, &across, T::one());
    }
    Some(log_det + factor_block(a, second, inverses)?)
}

/// X with X Lᵀ = A in place of A on some rows and columns, L on the same columns.
fn solve<T: RealField + Copy>(
    a: &mut DMatrix<T>,
    rows: &Range<usize>,
    columns: Range<usize>,
    inverses: &[(usize, DMatrix<T>)],
) {
    let Some([first, second]) = halves(&columns) else {
        let Ok(at) = inverses.binary_search_by_key(&columns.start, |(start, _)| *start) else { return };
        let mut target = a.view_mut((rows.start, columns.start), (rows.len(), columns.len()));
        let inverse = &inverses[at].1;
        let across = transposed(inverse.as_slice(), inverse.nrows(), 0..columns.len(), 0..columns.len());
        let solved = &target * across;
        target.copy_from(&solved);
        return;
    };
    solve(a, rows, first.clone(), inverses);
    let n = a.nrows();
    let (left, right) = a.as_mut_slice().split_at_mut(second.start * n);
    let solved = view(left, n, rows.clone(), first.clone());
    let across = transposed(left, n, second.clone(), first);
    view_mut(right, n, rows.clone(), 0..second.len()).gemm(-T::one(), &solved, &across, T::one());
    solve(a, rows, second, inverses);
}

/// R in place of L on a block of the diagonal, zero below it. `product`: room for a block beside the diagonal.
fn invert<T: RealField + Copy>(root: &mut DMatrix<T>, block: Range<usize>, product: &mut [T]) -> Option<()> {
    let Some([first, second]) = halves(&block) else {
        let mut of_block = root.view_mut((block.start, block.start), (block.len(), block.len()));
        let inverse = inverse_of_small(&of_block.clone_owned())?;
        of_block.tr_copy_from(&inverse);
        return Some(());
    };
    invert(root, first.clone(), product)?;
    invert(root, second.clone(), product)?;
    let n = root.nrows();
    let (left, right) = root.as_mut_slice().split_at_mut(second.start * n);
    let rows = first.len();
    for strip in strips(&first) {
        let triangle = view(left, n, strip.clone(), strip.start..first.end);
        let across = transposed(left, n, second.clone(), strip.start..first.end);
        let from = strip.start - first.start;
        view_mut(product, rows, from..from + strip.len(), 0..second.len()).gemm(
            T::one(),
            &triangle,
            &across,
            T::zero(),
        );
    }
    for strip in strips(&second) {
        let columns = strip.start - second.start..strip.end - second.start;
        let mut whole = view_mut(right, n, 0..n, columns.clone());
        let (mut above, triangle) = whole.rows_range_pair_mut(first.clone(), second.start..strip.end);
        above.gemm(-T::one(), &view(product, rows, 0..rows, 0..columns.end), &triangle, T::zero());
    }
    // What strips of triangles reach over the diagonal.
    let (above, below) =
        (second.start.saturating_sub(STRIP).max(first.start), second.end.min(second.start + STRIP));
    view_mut(left, n, second.start..below, above..second.start).fill(T::zero());
    Some(())
}

/// The lower triangle of RRᵀ in place of R on a block of the diagonal: what stands beside the diagonal first, while R is there.
fn square<T: RealField + Copy>(root: &mut DMatrix<T>, block: Range<usize>) {
    let n = root.nrows();
    let Some([first, second]) = halves(&block).filter(|_| block.len() > STRIP) else {
        let mut of_block = root.view_mut((block.start, block.start), (block.len(), block.len()));
        let triangle = of_block.clone_owned();
        of_block.gemm(T::one(), &triangle, &triangle.transpose(), T::zero());
        return;
    };
    let (left, right) = root.as_mut_slice().split_at_mut(second.start * n);
    for strip in strips(&second) {
        let triangle = strip.start - second.start..second.len();
        let across = transposed(right, n, first.clone(), triangle.clone());
        view_mut(left, n, strip.clone(), first.clone()).gemm(
            T::one(),
            &view(right, n, strip, triangle),
            &across,
            T::zero(),
        );
    }
    square(root, first.clone());
    let (left, right) = root.as_mut_slice().split_at_mut(second.start * n);
    for strip in strips(&first) {
        let below = view(right, n, strip.start..first.end, 0..second.len());
        let across = transposed(right, n, strip.clone(), 0..second.len());
        view_mut(left, n, strip.start..first.end, strip).gemm(T::one(), &below, &across, T::one());
    }
    square(root, second);
}

/// The lower triangle above the diagonal, in squares that fit into the nearest cache.
fn mirror<T: RealField + Copy>(a: &mut DMatrix<T>) {
    let n = a.nrows();
    let all = a.as_mut_slice();
    for from in (0..n).step_by(TILE) {
        for beside in (from..n).step_by(TILE) {
            for column in from..(from + TILE).min(n) {
                for row in beside.max(column + 1)..(beside + TILE).min(n) {
                    all[row * n + column] = all[column * n + row];
                }
            }
        }
    }
}

fn inverse_of_small<T: RealField + Copy>(lower: &DMatrix<T>) -> Option<DMatrix<T>> {
    lower.solve_lower_triangular(&DMatrix::identity(lower.nrows(), lower.nrows()))
}

/// `None` of a block that is small.
fn halves(block: &Range<usize>) -> Option<[Range<usize>; 2]> {
    let middle = block.start + block.len().div_ceil(2);
    (block.len() > SMALL).then_some([block.start..middle, middle..block.end])
}

fn strips(range: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let end = range.end;
    range.clone().step_by(STRIP).map(move |from| from..(from + STRIP).min(end))
}

/// Rows and columns of whole columns of `n` rows.
fn view<T: RealField>(
    of: &[T],
    n: usize,
    rows: Range<usize>,
    columns: Range<usize>,
) -> DMatrixView<'_, T, Dyn, Dyn> {
    DMatrixView::from_slice_with_strides(
        &of[columns.start * n + rows.start..],
        rows.len(),
        columns.len(),
        1,
        n,
    )
}

/// The same with rows and columns exchanged, without a copy.
fn transposed<T: RealField>(
    of: &[T],
    n: usize,
    rows: Range<usize>,
    columns: Range<usize>,
) -> DMatrixView<'_, T, Dyn, Dyn> {
    DMatrixView::from_slice_with_strides(
        &of[columns.start * n + rows.start..],
        columns.len(),
        rows.len(),
        n,
        1,
    )
}

fn view_mut<T: RealField>(
    of: &mut [T],
    n: usize,
    rows: Range<usize>,
    columns: Range<usize>,
) -> DMatrixViewMut<'_, T, Dyn, Dyn> {
    let from = &mut of[columns.start * n + rows.start..];
    DMatrixViewMut::from_slice_with_strides_mut(from, rows.len(), columns.len(), 1, n)
}

fn number<T: RealField + Copy>(value: T) -> f64 {
    value.to_subset().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::learned::Real;

    /// More than two strips in each half, the last one short.
    #[test]
    fn inverse_and_determinant_agree_with_the_plain_ones() {
        let n = 5 * STRIP + 7;
        let root = DMatrix::from_fn(n, n, |i, j| ((i * 37 + j * 11 + i * j) % 23) as f64 / 23.0 - 0.5);
        let a = &root * root.transpose() + DMatrix::identity(n, n);
        let mut root = a.clone();
        let log_det = factor(&mut root).unwrap();
        let found = inverse(root).unwrap();
        let plain = a.clone().cholesky().unwrap();
        assert!((plain.inverse() - found).amax() < 1e-9);
        let plain: f64 = plain.l_dirty().diagonal().iter().map(|x| 2.0 * x.ln()).sum();
        assert!((log_det - plain).abs() < 1e-8, "{log_det} {plain}");
        let mut root = a.clone().cast::<Real>();
        let single = factor(&mut root).unwrap();
        let found = inverse(root).unwrap();
        assert!((log_det - single).abs() < 0.05, "{log_det} {single}");
        assert!((&a * found.cast::<f64>() - DMatrix::identity(n, n)).amax() < 0.05);
        assert!(factor(&mut (a - DMatrix::identity(n, n) * 2.0)).is_none());
    }
}
