//! Least-squares sphere: the centre of a probed ball.

use super::{GeometryError, round::round, scatter::rms};
use nalgebra::Vector3;

/// A sphere and how far the points are from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, mm.
    pub centre_mm: Vector3<f64>,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Distance of each point from the centre minus the radius, mm.
    pub deviation_mm: Vec<f64>,
    /// Root mean square of the deviations, mm.
    pub rms_mm: f64,
}

/// The sphere with the least sum of squared radial distances (Forbes 1989, §6).
///
/// # Errors
/// Fewer than four points, a coordinate that is no number, points in a plane.
pub fn sphere(points_mm: &[Vector3<f64>]) -> Result<Sphere, GeometryError> {
    let (centre_mm, radius_mm) = round("sphere", points_mm)?;
    let deviation_mm: Vec<f64> = points_mm.iter().map(|p| (p - centre_mm).norm() - radius_mm).collect();
    let rms_mm = rms(&deviation_mm);
    Ok(Sphere { centre_mm, radius_mm, deviation_mm, rms_mm })
}
