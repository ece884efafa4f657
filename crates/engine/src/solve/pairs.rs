//! Matrices over pairs of points.

use nalgebra::DMatrix;

/// A symmetric matrix, each pair asked for once: i is not less than j.
pub(crate) fn symmetric(points: usize, of_pair: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let mut pairs = DMatrix::zeros(points, points);
    for j in 0..points {
        for i in j..points {
            pairs[(i, j)] = of_pair(i, j);
        }
    }
    pairs.fill_upper_triangle_with_lower_triangle();
    pairs
}
