//! Least-squares circle: the centre about which ISO 230-4 and ISO 230-7 count deviations.

use super::{GeometryError, round::round, scatter::rms};
use nalgebra::Vector2;

/// A circle and how far the points are from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Centre, mm.
    pub centre_mm: Vector2<f64>,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Distance of each point from the centre minus the radius, mm.
    pub deviation_mm: Vec<f64>,
    /// Root mean square of the deviations, mm.
    pub rms_mm: f64,
}

/// The circle with the least sum of squared radial distances (Gander, Golub, Strebel 1994).
///
/// # Errors
/// Fewer than three points, a coordinate that is no number, points on a line.
pub fn circle(points_mm: &[Vector2<f64>]) -> Result<Circle, GeometryError> {
    let (centre_mm, radius_mm) = round("circle", points_mm)?;
    let deviation_mm: Vec<f64> = points_mm.iter().map(|p| (p - centre_mm).norm() - radius_mm).collect();
    let rms_mm = rms(&deviation_mm);
    Ok(Circle { centre_mm, radius_mm, deviation_mm, rms_mm })
}
