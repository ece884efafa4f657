//! Platform of three parallel legs, by this crate's own equations: places and distances instead of leg angles.
//!
//! Unknown: place p of the platform, tilt α and turn θ, R = R_x(α) R_y(θ).   B_i = p + R b_i
//!   |B_i − A_i|² = q_i²  (three legs)
//!   legs 1 and 3 lie in the plane that tilts by α about the line of their base joints: `(R_x(α)ᵀ(B₁ − A₁))_y = 0`
//!   leg 2 stands across the platform's X: `(B₂ − A₂)·R x̂ = 0`                        [S3 fig. 1–2: 2-UPR-SPR]
//! Newton with derivatives by differences.

use super::rotation::turned;
use nalgebra::{Matrix3, Matrix4, SMatrix, SVector, Vector3};
use trunnion_core::{AxisValues, Twist};
use trunnion_machine::{Machine, Tripod};

type Unknown = SVector<f64, 5>;

const MOST_STEPS: usize = 60;
/// Differences for derivatives, mm and rad.
const NEAR: [f64; 5] = [1e-4, 1e-4, 1e-4, 1e-7, 1e-7];
/// A step this small has arrived, mm.
const ARRIVED: f64 = 1e-13;
/// The equations hold to this, mm.
const CLOSED_MM: f64 = 1e-9;
/// Longest step of an angle, rad.
const LONGEST_RAD: f64 = 0.2;

/// Pose of the platform against its pose at zero, machine axes; the identity for a machine without legs.
///
/// # Panics
/// When the legs cannot meet the platform: a cycle beyond the travels of the legs.
pub fn platform(machine: &Machine, position: &AxisValues<f64>, errors: &AxisValues<Twist>) -> Matrix4<f64> {
    let Some(tripod) = &machine.tripod else { return Matrix4::identity() };
    let mut actual = *position;
    for axis in machine.tool.iter().filter(|axis| tripod.has(axis.letter)) {
        let along = axis.direction.into_inner() * axis.sense;
        actual[axis.letter] += errors[axis.letter].translation_mm.dot(&along);
    }
    let machine_from_base = tripod.machine_from_base().to_homogeneous();
    let pose = |strokes: &AxisValues<f64>| machine_from_base * base_from_platform(tripod, strokes);
    let at_zero = pose(&AxisValues::default());
    pose(&actual) * at_zero.try_inverse().expect("a pose has an inverse")
}

fn base_from_platform(tripod: &Tripod, strokes: &AxisValues<f64>) -> Matrix4<f64> {
    let legs = tripod.legs();
    let lengths_mm = legs.each_ref().map(|leg| leg.length_at_zero_mm + leg.sense * strokes[leg.letter]);
    let middle = (legs[0].base_joint_mm + legs[2].base_joint_mm) / 2.0;
    let deep = lengths_mm.iter().sum::<f64>() / 3.0;
    let mut unknown = Unknown::new(middle.x, middle.y, middle.z - deep, 0.0, 0.0);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let open = equations(tripod, &lengths_mm, &unknown);
        let slope = SMatrix::<f64, 5, 5>::from_columns(&std::array::from_fn::<_, 5, _>(|k| {
            let mut near = Unknown::zeros();
            near[k] = NEAR[k];
            let ahead = equations(tripod, &lengths_mm, &(unknown + near));
            let behind = equations(tripod, &lengths_mm, &(unknown - near));
            (ahead - behind) / (2.0 * NEAR[k])
        }));
        let step = slope.lu().solve(&open).expect("the legs are not in a singular pose");
        let shorten = (LONGEST_RAD / step.fixed_rows::<2>(3).amax()).min(1.0);
        unknown -= step * shorten;
        let size = step.amax();
        if size < ARRIVED || (size < 1e-9 && size >= last) {
            break;
        }
        last = size;
    }
    let open_mm = equations(tripod, &lengths_mm, &unknown).amax();
    assert!(open_mm < CLOSED_MM, "the legs cannot meet the platform at {lengths_mm:?} mm");
    let mut pose = rotation(&unknown).to_homogeneous();
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&unknown.fixed_rows::<3>(0));
    pose
}

fn rotation(unknown: &Unknown) -> Matrix3<f64> {
    turned(&Vector3::x(), unknown[3]) * turned(&Vector3::y(), unknown[4])
}

fn equations(tripod: &Tripod, lengths_mm: &[f64; 3], unknown: &Unknown) -> Unknown {
    let turn = rotation(unknown);
    let place = unknown.fixed_rows::<3>(0).into_owned();
    let legs = tripod.legs();
    let leg = |i: usize| place + turn * legs[i].platform_joint_mm - legs[i].base_joint_mm;
    // In mm: the difference of the squares over twice the length.
    let too_long = |i: usize| (leg(i).norm_squared() - lengths_mm[i].powi(2)) / (2.0 * lengths_mm[i]);
    let out_of_plane = (turned(&Vector3::x(), unknown[3]).transpose() * leg(0)).y;
    Unknown::new(too_long(0), too_long(1), too_long(2), out_of_plane, leg(1).dot(&turn.column(0)))
}
