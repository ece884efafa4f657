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
const STRIP: usize = 128;

/// ln det of a matrix of which the lower triangle is given, with L in place of that; `None` where it is not positive definite.
pub(super) fn factor<T: RealField + Copy>(a: &mut DMatrix<T>) -> Option<f64> {
    let rows = 0..a.nrows();
    factor_block(a, rows, &mut Vec::new()).filter(|log_det| log_det.is_finite())
}

/// A⁻¹ from L.
pub(super) fn inverse<T: RealField + Copy>(mut root: DMatrix<T>) -> Option<DMatrix<T>> {
    let n = root.nrows();
    invert(&mut root, 0..n)?;
    let mut inverse = DMatrix::zeros(n, n);
    square(&root, &mut inverse, 0..n);
    inverse.fill_upper_triangle_with_lower_triangle();
    Some(inverse)
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

/// R in place of L on a block of the diagonal, zero below it.
fn invert<T: RealField + Copy>(root: &mut DMatrix<T>, block: Range<usize>) -> Option<()> {
    let Some([first, second]) = halves(&block) else {
        let mut of_block = root.view_mut((block.start, block.start), (block.len(), block.len()));
        let inverse = inverse_of_small(&of_block.clone_owned())?;
        of_block.tr_copy_from(&inverse);
        return Some(());
    };
    invert(root, first.clone())?;
    invert(root, second.clone())?;
    let n = root.nrows();
    let (left, right) = root.as_mut_slice().split_at_mut(second.start * n);
    let mut product = DMatrix::zeros(first.len(), second.len());
    for strip in strips(&first) {
        let triangle = view(left, n, strip.clone(), strip.start..first.end);
        let across = transposed(left, n, second.clone(), strip.start..first.end);
        product.rows_mut(strip.start - first.start, strip.len()).gemm(
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
        above.gemm(-T::one(), &product.columns(0, columns.end), &triangle, T::zero());
    }
    view_mut(left, n, second, first).fill(T::zero());
    Some(())
}

/// The lower triangle of RRᵀ on a block of the diagonal.
fn square<T: RealField + Copy>(root: &DMatrix<T>, into: &mut DMatrix<T>, block: Range<usize>) {
    let (n, of) = (root.nrows(), root.as_slice());
    let Some([first, second]) = halves(&block).filter(|_| block.len() > STRIP) else {
        let mut target = into.view_mut((block.start, block.start), (block.len(), block.len()));
        let across = transposed(of, n, block.clone(), block.clone());
        target.gemm(T::one(), &view(of, n, block.clone(), block), &across, T::zero());
        return;
    };
    square(root, into, first.clone());
    square(root, into, second.clone());
    for strip in strips(&first) {
        let across = transposed(of, n, strip.clone(), second.clone());
        let mut target = into.view_mut((strip.start, strip.start), (first.end - strip.start, strip.len()));
        target.gemm(T::one(), &view(of, n, strip.start..first.end, second.clone()), &across, T::one());
    }
    for strip in strips(&second) {
        let across = transposed(of, n, first.clone(), strip.start..second.end);
        let mut target = into.view_mut((strip.start, first.start), (strip.len(), first.len()));
        target.gemm(T::one(), &view(of, n, strip.clone(), strip.start..second.end), &across, T::zero());
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
