//! From rows to points and back: what a kernel moves alike are points, what a covariance and columns have are rows.

use super::{Frame, Kernels, Over};
use crate::noise::learned::Real;
use nalgebra::{DMatrix, DVector, RealField};
use std::ops::Range;

impl Kernels {
    /// Σ over the rows of each pair of points of `matrix` ∘ gram, `matrix` symmetric; of each point with itself alone where no kernel of
    /// the frame asks for more.
    pub fn contracted(&self, frame: usize, matrix: &DMatrix<Real>) -> DMatrix<Real> {
        let (rows, points) = (matrix.nrows(), self.points);
        let (matrix, gram) = (matrix.as_slice(), self.frames[frame].gram.as_slice());
        let mut sums = DMatrix::zeros(points, points);
        let mut products = vec![0.0; rows];
        for (point, Range { start: first, end }) in self.rows_of_point.iter().cloned().enumerate() {
            let last = if self.is_own(frame) { end } else { rows };
            let products = &mut products[first..last];
            products.fill(0.0);
            for column in first..end {
                let below = column * rows + first..column * rows + last;
                for ((product, a), b) in products.iter_mut().zip(&matrix[below.clone()]).zip(&gram[below]) {
                    *product += a * b;
                }
            }
            self.summed(point, products, &mut sums.as_mut_slice()[point * points..(point + 1) * points]);
        }
        sums.fill_upper_triangle_with_lower_triangle();
        sums
    }

    /// Whether every point goes by itself in a frame.
    pub fn is_own(&self, frame: usize) -> bool {
        self.list.iter().all(|kernel| kernel.frame != frame || matches!(kernel.over, Over::Own))
    }

    /// Adds values of the rows of points from `first` on, to the sums of their points.
    fn summed(&self, first: usize, of_rows: &[Real], sums: &mut [Real]) {
        match self.components {
            Some(1) => sum::<1>(of_rows, &mut sums[first..]),
            Some(3) => sum::<3>(of_rows, &mut sums[first..]),
            _ => {
                let points = &self.point_of_row[self.rows_of_point[first].start..];
                of_rows.iter().zip(points).for_each(|(value, &point)| sums[point] += value);
            }
        }
    }

    /// The value of each point from `first` on, at its rows.
    pub fn spread(&self, first: usize, of_points: &[Real], of_rows: &mut [Real]) {
        match self.components {
            Some(1) => spread::<1>(&of_points[first..], of_rows),
            Some(3) => spread::<3>(&of_points[first..], of_rows),
            _ => {
                let points = &self.point_of_row[self.rows_of_point[first].start..];
                of_rows.iter_mut().zip(points).for_each(|(value, &point)| *value = of_points[point]);
            }
        }
    }

    /// Sums over the rows of each point of lever ∘ v: point × direction.
    pub fn folded(&self, frame: &Frame, v: &DVector<Real>) -> DMatrix<Real> {
        let mut sums = DMatrix::zeros(self.points, frame.lever.ncols());
        for (row, &point) in self.point_of_row.iter().enumerate() {
            for k in 0..frame.lever.ncols() {
                sums[(point, k)] += frame.lever[(row, k)] * v[row];
            }
        }
        sums
    }

    /// The same of several columns: point × column for each direction.
    pub fn folded_columns<T: RealField + Copy + From<Real>>(
        &self,
        frame: &Frame,
        columns: &DMatrix<T>,
    ) -> Vec<DMatrix<T>> {
        let of_direction = |k: usize| {
            let mut sums = DMatrix::zeros(self.points, columns.ncols());
            for (mut sums, column) in sums.column_iter_mut().zip(columns.column_iter()) {
                for ((&point, lever), value) in
                    self.point_of_row.iter().zip(&frame.lever.column(k)).zip(&column)
                {
                    sums[point] += T::from(*lever) * *value;
                }
            }
            sums
        };
        (0..frame.lever.ncols()).map(of_direction).collect()
    }

    /// Back to rows: lever · values of the row's point.
    pub fn unfolded(&self, frame: &Frame, values: &DMatrix<Real>) -> DVector<Real> {
        let of_row = |(row, &point): (usize, &usize)| {
            (0..frame.lever.ncols()).map(|k| frame.lever[(row, k)] * values[(point, k)]).sum::<Real>()
        };
        DVector::from_iterator(self.point_of_row.len(), self.point_of_row.iter().enumerate().map(of_row))
    }
}

/// Adds N values of each point to its sum.
fn sum<const N: usize>(of_rows: &[Real], sums: &mut [Real]) {
    for (sum, rows) in sums.iter_mut().zip(of_rows.as_chunks::<N>().0) {
        *sum += rows.iter().sum::<Real>();
    }
}

/// The value of each point, N times.
fn spread<const N: usize>(of_points: &[Real], of_rows: &mut [Real]) {
    for (rows, value) in of_rows.as_chunks_mut::<N>().0.iter_mut().zip(of_points) {
        *rows = [*value; N];
    }
}

#[cfg(test)]
pub(in crate::noise::learned) mod tests {
    use super::*;
    use crate::noise::learned::kernels::{Kernel, Part};

    /// Points of so many rows each in two frames: a kernel of pairs in the first, every point by itself in the second.
    pub(in crate::noise::learned) fn kernels(rows_of_points: &[usize]) -> Kernels {
        let points = rows_of_points.len();
        let mut next = 0;
        let rows_of_point: Vec<Range<usize>> = rows_of_points
            .iter()
            .map(|rows| {
                next += rows;
                next - rows..next
            })
            .collect();
        let point_of_row =
            rows_of_point.iter().enumerate().flat_map(|(i, rows)| rows.clone().map(move |_| i)).collect();
        let lever = |directions, start: usize| {
            Frame::of(DMatrix::from_fn(next, directions, |i, j| ((start + 7 * i + 5 * j) % 11) as Real - 4.0))
        };
        let pairs = DMatrix::from_fn(points, points, |i, j| (-(i as Real - j as Real).abs() / 3.0).exp());
        let kernel = |frame, over| Kernel { part: Part::Drift, frame, over, mean_ln: -1.0, spread_ln: 1.0 };
        let same = rows_of_points.iter().all(|rows| *rows == rows_of_points[0]);
        Kernels {
            list: vec![kernel(0, Over::Pairs(pairs)), kernel(1, Over::Own)],
            frames: vec![lever(3, 0), lever(1, 3)],
            points,
            point_of_row,
            rows_of_point,
            components: same.then_some(rows_of_points[0]),
            single: 1.0,
        }
    }

    #[test]
    fn a_matrix_is_contracted_as_element_by_element() {
        for rows_of_points in [vec![3; 5], vec![1; 6], vec![3, 1, 3, 3, 1]] {
            let kernels = kernels(&rows_of_points);
            let rows = kernels.point_of_row.len();
            let matrix =
                DMatrix::from_fn(rows, rows, |i, j| (((i + 1) * (j + 1) + i + j) % 13) as Real / 13.0);
            for frame in 0..2 {
                let mut plain = DMatrix::zeros(kernels.points, kernels.points);
                for i in 0..rows {
                    for j in 0..rows {
                        let (a, b) = (kernels.point_of_row[i], kernels.point_of_row[j]);
                        if frame == 0 || a == b {
                            plain[(a, b)] += matrix[(i, j)] * kernels.frames[frame].gram[(i, j)];
                        }
                    }
                }
                let found = kernels.contracted(frame, &matrix);
                assert!((&found - &plain).amax() < 1e-4 * plain.amax(), "{found} {plain}");
            }
        }
    }
}
