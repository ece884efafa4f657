//! Rotations.

use nalgebra::{Matrix3, Vector3};

/// Rodrigues: I + sin θ [k]× + (1 − cos θ) [k]×².
pub fn turned(along: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let cross = along.cross_matrix();
    Matrix3::identity() + cross * angle_rad.sin() + cross * cross * (1.0 - angle_rad.cos())
}
