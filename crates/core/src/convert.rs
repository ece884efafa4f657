//! Conversions between the inside (mm, rad, s) and the edges (µm, µrad, degrees, per minute).

use nalgebra::{Unit, Vector3};

/// Micrometres in a millimetre.
pub const UM_PER_MM: f64 = 1e3;
/// Microradians in a radian.
pub const URAD_PER_RAD: f64 = 1e6;

/// A direction from a vector of any length but zero. One of unit length but for rounding stays as it is: what was written reads back the same.
pub fn unit(vector: Vector3<f64>) -> Unit<Vector3<f64>> {
    let rounding = 4.0 * f64::EPSILON;
    if (vector.norm_squared() - 1.0).abs() <= rounding {
        Unit::new_unchecked(vector)
    } else {
        Unit::new_normalize(vector)
    }
}
/// mm from µm.
pub const fn mm_from_um(um: f64) -> f64 {
    um / UM_PER_MM
}
/// µm from mm.
pub const fn um_from_mm(mm: f64) -> f64 {
    mm * UM_PER_MM
}
/// rad from degrees.
pub const fn rad_from_deg(deg: f64) -> f64 {
    deg.to_radians()
}
/// Degrees from rad.
pub const fn deg_from_rad(rad: f64) -> f64 {
    rad.to_degrees()
}
/// rad from µrad.
pub const fn rad_from_urad(urad: f64) -> f64 {
    urad / URAD_PER_RAD
}
/// µrad from rad.
pub const fn urad_from_rad(rad: f64) -> f64 {
    rad * URAD_PER_RAD
}
/// s from minutes.
pub const fn s_from_min(min: f64) -> f64 {
    min * 60.0
}
