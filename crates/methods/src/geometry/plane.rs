//! Least-squares plane: the plane of a measured circle, a probed face.

use super::{
    GeometryError,
    scatter::{Scatter, pointing_up, rms},
};
use nalgebra::Vector3;

/// A plane and how far the points are from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// The centroid of the points, which lies in the plane, mm.
    pub through_mm: Vector3<f64>,
    /// Unit normal; its largest component is positive.
    pub normal: Vector3<f64>,
    /// Distance of each point from the plane along the normal, mm.
    pub deviation_mm: Vec<f64>,
    /// Root mean square of the deviations, mm.
    pub rms_mm: f64,
}

/// The plane with the least sum of squared orthogonal distances (Pearson 1901; Forbes 1989, §5).
///
/// # Errors
/// Fewer than three points, a coordinate that is no number, points on a line or without any flat side.
pub fn plane(points_mm: &[Vector3<f64>]) -> Result<Plane, GeometryError> {
    let scatter = Scatter::of("plane", 3, points_mm)?;
    let undetermined = |why| Err(GeometryError::Undetermined { shape: "plane", why });
    if !scatter.spans(2) {
        return undetermined("they lie on a line");
    }
    if scatter.spread[2] > (1.0 - 1e-12) * scatter.spread[1] {
        return undetermined("they have no flat side");
    }
    let normal = pointing_up(scatter.directions[2]);
    let deviation_mm: Vec<f64> = points_mm.iter().map(|p| (p - scatter.centroid).dot(&normal)).collect();
    let rms_mm = rms(&deviation_mm);
    Ok(Plane { through_mm: scatter.centroid, normal, deviation_mm, rms_mm })
}
