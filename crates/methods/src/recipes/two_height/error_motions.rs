//! Error motions, in the signs that are shown.

use super::fit::Heights;
use crate::common::turning::Turning;
use crate::recipes::Convention;
use nalgebra::{Vector2, Vector3};
use trunnion_effects::Unit;

/// Signs by which right-handed values become those that are shown.
pub(super) struct Signs {
    /// Of the error motions in u, v, w.
    pub translation: f64,
    /// Of the tilt of the average line about u, the one that v over height gives.
    pub tilt_u_of_line: f64,
}

impl Signs {
    /// S0 eq. 1–2: translations opposite; eq. 3: E_A0C opposite, E_Y0C the same number.
    pub fn of(convention: Convention) -> Self {
        let sign = match convention {
            Convention::RightHanded => 1.0,
            Convention::Source => -1.0,
        };
        Self { translation: sign, tilt_u_of_line: sign }
    }
}

/// One error motion over the angle.
pub(super) struct ErrorMotion {
    pub name: String,
    pub unit: Unit,
    /// Angle and value.
    pub points: Vec<(f64, f64)>,
    /// Standard uncertainty of one value.
    pub u: Option<f64>,
}

/// The five error motions, in the signs that are shown.
pub(super) fn error_motions(turning: &Turning, heights: &Heights, signs: &Signs) -> Vec<ErrorMotion> {
    let over_angle = |of: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        heights.angles_rad.iter().enumerate().map(|(i, &angle)| (angle, of(i))).collect()
    };
    let mut motions = Vec::new();
    for k in 0..3 {
        let points = over_angle(&|i| signs.translation * heights.translation_mm[i][k]);
        let u = heights.u_translation_mm.map(|u: Vector3<f64>| u[k]);
        let name = turning.symbol(turning.frame[k], false);
        motions.push(ErrorMotion { name, unit: Unit::UM, points, u });
    }
    for k in 0..2 {
        let points = over_angle(&|i| heights.tilt_rad[i][k]);
        let u = heights.u_tilt_rad.map(|u: Vector2<f64>| u[k]);
        let name = turning.symbol(turning.rotations()[k], false);
        motions.push(ErrorMotion { name, unit: Unit::URAD, points, u });
    }
    motions
}
