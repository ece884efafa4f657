//! The closure of the three legs as equations in six angles, and its derivatives.

use super::leg::Leg;
use nalgebra::{Matrix6, SVector, UnitQuaternion, Vector3, Vector6};

/// α, θ, β₁, β₃, α₂, β₂.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Angles {
    pub tilt: f64,
    pub turn: f64,
    pub beta_1: f64,
    pub beta_3: f64,
    pub alpha_2: f64,
    pub beta_2: f64,
}

/// Angles with the platform straight below its joints, legs towards it.
pub(super) fn guess(legs: &[Leg; 3]) -> Angles {
    let middle = (legs[0].base_joint_mm + legs[2].base_joint_mm) / 2.0;
    let depth = legs.iter().map(|leg| leg.length_at_zero_mm).sum::<f64>() / 3.0;
    let angles = |leg: &Leg| {
        let across = middle + leg.platform_joint_mm - leg.base_joint_mm;
        // R(α) R(β) (0, 0, −1) = (−sin β, sin α cos β, −cos α cos β).
        let beta = (-across.x / depth).clamp(-0.9, 0.9).asin();
        (across.y.atan2(depth), beta)
    };
    let (alpha_2, beta_2) = angles(&legs[1]);
    Angles { tilt: 0.0, turn: 0.0, beta_1: angles(&legs[0]).1, beta_3: angles(&legs[2]).1, alpha_2, beta_2 }
}

/// O_M by each leg, base axes, mm [S3 eq. 4].
pub(super) fn origins_mm(legs: &[Leg; 3], angles: &Angles, lengths_mm: &[f64; 3]) -> [Vector3<f64>; 3] {
    std::array::from_fn(|i| {
        let leg = &legs[i];
        leg.base_joint_mm + angles.leg(i) * lengths_mm[i] - angles.platform() * leg.platform_joint_mm
    })
}

/// What must vanish, mm: O_M2 − O_M1, the in-plane components of O_M3 − O_M1, and leg 2 along the platform's X.
pub(super) fn closure(legs: &[Leg; 3], angles: &Angles, lengths_mm: &[f64; 3]) -> Vector6<f64> {
    let origins = origins_mm(legs, angles, lengths_mm);
    let second = origins[1] - origins[0];
    let third = angles.plane().inverse() * (origins[2] - origins[0]);
    let out_of_hinge = angles.leg(1).dot(&(angles.platform() * Vector3::x())) * lengths_mm[1];
    Vector6::new(second.x, second.y, second.z, third.x, third.z, out_of_hinge)
}

/// Derivatives of the closure with respect to the angles.
pub(super) fn slope(legs: &[Leg; 3], angles: &Angles, lengths_mm: &[f64; 3]) -> Matrix6<f64> {
    let (axis_tilt, axis_turn) = (Vector3::x(), angles.hinge());
    let platform = angles.platform();
    let leg = |i: usize| angles.leg(i) * lengths_mm[i];
    let arm = |i: usize| platform * -legs[i].platform_joint_mm;
    let into_plane = angles.plane().inverse();
    let mut slope = Matrix6::zeros();
    let mut column = |j: usize, second: Vector3<f64>, third: Vector3<f64>, hinge: f64| {
        let third = into_plane * third;
        slope.set_column(j, &Vector6::new(second.x, second.y, second.z, third.x, third.z, hinge));
    };
    let x_platform = platform * Vector3::x();
    let tilted = |i: usize| axis_tilt.cross(&arm(i));
    let with_first = axis_tilt.cross(&leg(0)) + tilted(0);
    // The plane of legs 1 and 3 tilts as a whole: nothing opens in it.
    let hinge_by_tilt = leg(1).dot(&axis_tilt.cross(&x_platform));
    column(0, tilted(1) - with_first, Vector3::zeros(), hinge_by_tilt);
    let turned = |i: usize| axis_turn.cross(&arm(i));
    let hinge_by_turn = leg(1).dot(&axis_turn.cross(&x_platform));
    column(1, turned(1) - turned(0), turned(2) - turned(0), hinge_by_turn);
    let first = axis_turn.cross(&leg(0));
    column(2, -first, -first, 0.0);
    column(3, Vector3::zeros(), axis_turn.cross(&leg(2)), 0.0);
    let by_alpha_2 = axis_tilt.cross(&leg(1));
    column(4, by_alpha_2, Vector3::zeros(), by_alpha_2.dot(&x_platform));
    let by_beta_2 = (about_x(angles.alpha_2) * Vector3::y()).cross(&leg(1));
    column(5, by_beta_2, Vector3::zeros(), by_beta_2.dot(&x_platform));
    slope
}

/// Derivatives of the closure with respect to the three lengths.
pub(super) fn by_length(angles: &Angles) -> [Vector6<f64>; 3] {
    let into_plane = angles.plane().inverse();
    let column = |second: Vector3<f64>, third: Vector3<f64>, hinge: f64| {
        let third = into_plane * third;
        Vector6::new(second.x, second.y, second.z, third.x, third.z, hinge)
    };
    let [first, second, third] = std::array::from_fn(|i| angles.leg(i));
    let x_platform = angles.platform() * Vector3::x();
    [
        column(-first, -first, 0.0),
        column(second, Vector3::zeros(), second.dot(&x_platform)),
        column(Vector3::zeros(), third, 0.0),
    ]
}

impl Angles {
    /// Plane of legs 1 and 3: R(α).
    pub fn plane(&self) -> UnitQuaternion<f64> {
        about_x(self.tilt)
    }

    /// Base from platform axes: R(θ_YZ) R(θ_XZ).
    pub fn platform(&self) -> UnitQuaternion<f64> {
        about_x(self.tilt) * about_y(self.turn)
    }

    /// The axis of the hinges of legs 1 and 3.
    pub fn hinge(&self) -> Vector3<f64> {
        self.plane() * Vector3::y()
    }

    /// Unit vector of leg i (from zero), base axes: R(α_i) R(β_i) (0, 0, −1).
    pub fn leg(&self, i: usize) -> Vector3<f64> {
        let (alpha, beta) = match i {
            0 => (self.tilt, self.beta_1),
            1 => (self.alpha_2, self.beta_2),
            _ => (self.tilt, self.beta_3),
        };
        about_x(alpha) * about_y(beta) * -Vector3::z()
    }

    pub fn plus(&self, step: &SVector<f64, 6>) -> Self {
        Self {
            tilt: self.tilt + step[0],
            turn: self.turn + step[1],
            beta_1: self.beta_1 + step[2],
            beta_3: self.beta_3 + step[3],
            alpha_2: self.alpha_2 + step[4],
            beta_2: self.beta_2 + step[5],
        }
    }
}

/// Rotation about X.
pub(super) fn about_x(angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle_rad)
}

fn about_y(angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle_rad)
}
