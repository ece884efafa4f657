//! Least-squares line in the plane or in space: an axis line, a straightness reference.

use super::{
    GeometryError,
    scatter::{Scatter, pointing_up, rms},
};
use nalgebra::SVector;

/// A line in N dimensions and how far the points are from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Line<const N: usize> {
    /// The centroid of the points, which lies on the line, mm.
    pub through_mm: SVector<f64, N>,
    /// Unit vector along the line; its largest component is positive.
    pub direction: SVector<f64, N>,
    /// Vector from the line to each point, mm.
    pub deviation_mm: Vec<SVector<f64, N>>,
    /// Root mean square of the orthogonal distances, mm.
    pub rms_mm: f64,
}

/// The line with the least sum of squared orthogonal distances (Pearson 1901; Forbes 1989, §4), N = 2 or 3.
///
/// # Errors
/// Fewer than two points, a coordinate that is no number, all points in one place or spread alike in two directions.
pub fn line<const N: usize>(points_mm: &[SVector<f64, N>]) -> Result<Line<N>, GeometryError> {
    let scatter = Scatter::of("line", 2, points_mm)?;
    let same = scatter.spread[1] > (1.0 - 1e-12) * scatter.spread[0];
    if !scatter.spans(1) || same {
        let why = if same && scatter.spread[0] > 0.0 {
            "they spread equally in two directions"
        } else {
            "they coincide"
        };
        return Err(GeometryError::Undetermined { shape: "line", why });
    }
    let direction = pointing_up(scatter.directions[0]);
    let deviation_mm: Vec<_> = points_mm
        .iter()
        .map(|p| p - scatter.centroid)
        .map(|about| about - direction * about.dot(&direction))
        .collect();
    let rms_mm = rms(&deviation_mm.iter().map(|d| d.norm()).collect::<Vec<_>>());
    Ok(Line { through_mm: scatter.centroid, direction, deviation_mm, rms_mm })
}
