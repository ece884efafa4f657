//! Poses of table and tool with errors, by 4×4 matrices of this crate's own.
//!
//! `machine_from_tip = Π T_k`, `T_k = Trans(o)·Dx Dy Dz·Da Db Dc(δ, ω)·Trans(−o)·Motion(q)` from the bed
//! outward [docs/design/physics.md §2.1; S1 eq. 6–7], a platform of parallel legs before the joints in series; o a point of a rotary axis' line, or the travelling carriage of a linear one.

use super::legs;
use super::rotation::turned;
use nalgebra::{Isometry3, Matrix3, Matrix4, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use trunnion_core::{AxisValues, Joint, Twist};
use trunnion_machine::{Axis, Machine, Side};

/// Pose of table or tool in the machine frame.
pub fn machine_from_tip(
    machine: &Machine,
    side: Side,
    position: &AxisValues<f64>,
    errors: &AxisValues<Twist>,
) -> Isometry3<f64> {
    let mut machine_from_tip = match side {
        Side::Tool => legs::platform(machine, position, errors),
        Side::Table => Matrix4::identity(),
    };
    for axis in machine.from_bed(side).into_iter().filter(|axis| !machine.is_leg(axis.letter)) {
        machine_from_tip *= carrier_from_carried(axis, position[axis.letter], &errors[axis.letter]);
    }
    let rotation: Matrix3<f64> = machine_from_tip.fixed_view::<3, 3>(0, 0).into_owned();
    let translation = machine_from_tip.fixed_view::<3, 1>(0, 3).into_owned();
    Isometry3::from_parts(
        Translation3::from(translation),
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)),
    )
}

fn carrier_from_carried(axis: &Axis, position: f64, error: &Twist) -> Matrix4<f64> {
    let along = axis.direction.into_inner();
    let travel = position * axis.sense;
    let (origin, motion) = if axis.is_rotary() {
        (axis.through_mm, about_point(&axis.through_mm, &turned(&along, travel)))
    } else {
        (Point3::from(along * travel), moved(&(along * travel)))
    };
    let [a, b, c] = [error.rotation_rad.x, error.rotation_rad.y, error.rotation_rad.z];
    let tilt = turned(&Vector3::x(), a) * turned(&Vector3::y(), b) * turned(&Vector3::z(), c);
    moved(&error.translation_mm) * about_point(&origin, &tilt) * motion
}

fn moved(by_mm: &Vector3<f64>) -> Matrix4<f64> {
    Matrix4::new_translation(by_mm)
}

fn about_point(point_mm: &Point3<f64>, rotation: &Matrix3<f64>) -> Matrix4<f64> {
    let mut pose = rotation.to_homogeneous();
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&(point_mm.coords - rotation * point_mm.coords));
    pose
}

/// Unit vector of an axis letter: X and A along x, Y and B along y, Z and C along z.
pub fn unit(letter: Joint) -> Vector3<f64> {
    Vector3::ith(letter.index() % 3, 1.0)
}
