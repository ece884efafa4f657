//! Centroid and principal directions of points in N dimensions.

use super::GeometryError;
use nalgebra::{DMatrix, SVector};
use trunnion_core::statistics;

/// Spread below this share of the largest is rounding.
const FLAT: f64 = 1e-12;

/// Principal directions of points, largest spread first.
pub(super) struct Scatter<const N: usize> {
    pub centroid: SVector<f64, N>,
    /// Root sum of squares along each direction, falling.
    pub spread: SVector<f64, N>,
    pub directions: [SVector<f64, N>; N],
}

impl<const N: usize> Scatter<N> {
    /// Singular value decomposition of the points about their centroid.
    pub fn of(shape: &'static str, least: usize, points: &[SVector<f64, N>]) -> Result<Self, GeometryError> {
        if let Some(point) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(GeometryError::NotFinite { shape, point });
        }
        if points.len() < least {
            return Err(GeometryError::TooFew { shape, least, found: points.len() });
        }
        let first = points[0];
        let centroid =
            first + points.iter().map(|p| p - first).sum::<SVector<f64, N>>() / points.len() as f64;
        // Padded to at least N rows, so that there are N right singular vectors.
        let about = DMatrix::from_fn(points.len().max(N), N, |i, j| {
            points.get(i).map_or(0.0, |p| p[j] - centroid[j])
        });
        let svd = about.svd(false, true);
        let rows = svd.v_t.expect("asked for");
        Ok(Self {
            centroid,
            spread: SVector::from_fn(|k, _| svd.singular_values[k]),
            directions: std::array::from_fn(|k| SVector::from_fn(|j, _| rows[(k, j)])),
        })
    }

    /// True when the points spread in at least `dimensions` directions.
    pub fn spans(&self, dimensions: usize) -> bool {
        self.spread[0] > 0.0 && self.spread[dimensions - 1] > FLAT * self.spread[0]
    }
}

/// `direction`, turned so that its largest component is positive.
pub(super) fn pointing_up<const N: usize>(direction: SVector<f64, N>) -> SVector<f64, N> {
    let largest = direction.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    if largest < 0.0 { -direction } else { direction }
}

/// Root mean square of distances.
pub(super) fn rms(distances: &[f64]) -> f64 {
    statistics::rms(distances.iter().copied()).unwrap_or(f64::NAN)
}
