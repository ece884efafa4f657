//! Exact forward kinematics with an error twist at every joint.
//!
//! `machine_from_tip = Π_k  T_k`,  `T_k = Trans(o_k)·Dx Dy Dz Da Db Dc(δ_k, ω_k)·Trans(−o_k)·Motion_k(q_k)`
//! from the bed outward [docs/design/physics.md §2.1; S1 eq. 6–7; S2 eq. 4]. `o_k` is the point in the axes of the carrying
//! component about which the error acts: a point of the axis line for a rotary axis; the carriage itself, which travels
//! with the axis, for a linear one (so that angular errors act with the arms of S2 eq. 1).
//! Legs in parallel come first: of their twists what acts along the leg is an error of the stroke [S3 eq. 4–6].

use crate::{Axis, Machine, Side};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use trunnion_core::{AxisValues, Twist};

/// Error twist at each joint, in the nominal axes of the component that carries it.
pub type JointErrors = AxisValues<Twist>;

/// A component of a machine against the one that carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// The component that carries.
    pub carrier: String,
    /// The component that is carried.
    pub carried: String,
    /// How the carried one stands; both coincide with the machine frame when every axis is at zero.
    pub carrier_from_carried: Isometry3<f64>,
}

impl Machine {
    /// Pose of the table (its frame coincides with the machine frame when every axis is at zero).
    pub fn machine_from_table(&self, position: &AxisValues<f64>, errors: &JointErrors) -> Isometry3<f64> {
        self.machine_from_tip(Side::Table, position, errors)
    }

    /// Pose of the tool point.
    pub fn machine_from_tool(&self, position: &AxisValues<f64>, errors: &JointErrors) -> Isometry3<f64> {
        self.machine_from_tip(Side::Tool, position, errors)
    }

    fn machine_from_tip(
        &self,
        side: Side,
        position: &AxisValues<f64>,
        errors: &JointErrors,
    ) -> Isometry3<f64> {
        let in_series = self.from_bed(side).into_iter().filter(|axis| !self.is_leg(axis.letter));
        in_series.fold(self.platform(side, position, errors), |machine_from_carrier, axis| {
            machine_from_carrier * axis.carrier_from_carried(position[axis.letter], &errors[axis.letter])
        })
    }

    /// Every component against the one that carries it, its joint nominal: from the bed outward, table side first. A component is
    /// called after the axis that moves it; `machine` is the bed, and `table` and `tool` are at the ends.
    pub fn links(&self, position: &AxisValues<f64>) -> Vec<Link> {
        let mut links = Vec::new();
        for (side, tip) in [(Side::Table, "table"), (Side::Tool, "tool")] {
            let mut carrier = "machine".to_owned();
            let mut link = |carried: &str, carrier_from_carried| {
                let carrier = std::mem::replace(&mut carrier, carried.into());
                links.push(Link { carrier, carried: carried.into(), carrier_from_carried });
            };
            if side == Side::Tool && self.tripod.is_some() {
                link("platform", self.platform(side, position, &JointErrors::default()));
            }
            for axis in self.from_bed(side).into_iter().filter(|axis| !self.is_leg(axis.letter)) {
                link(axis.letter.as_str(), axis.motion(position[axis.letter]));
            }
            link(tip, Isometry3::identity());
        }
        links
    }

    /// What carries the first axis in series: the bed, or the platform of the legs against its pose at zero.
    pub(crate) fn platform(
        &self,
        side: Side,
        position: &AxisValues<f64>,
        errors: &JointErrors,
    ) -> Isometry3<f64> {
        let Some(tripod) = self.tripod.as_ref().filter(|_| side == Side::Tool) else {
            return Isometry3::identity();
        };
        let mut strokes_mm = *position;
        for axis in self.tool.iter().filter(|axis| tripod.has(axis.letter)) {
            let positioning = axis.positioning_twist().translation_mm;
            strokes_mm[axis.letter] += errors[axis.letter].translation_mm.dot(&positioning);
        }
        tripod.displacement(&strokes_mm)
    }
}

impl Axis {
    /// `T_k` of this joint.
    fn carrier_from_carried(&self, position: f64, error: &Twist) -> Isometry3<f64> {
        let to_origin = Translation3::from(self.error_origin_mm(position).coords);
        to_origin * displacement(error) * to_origin.inverse() * self.motion(position)
    }

    /// `Motion_k(q_k)`, in the axes of the carrying component.
    pub(crate) fn motion(&self, position: f64) -> Isometry3<f64> {
        let amount = position * self.sense;
        if !self.is_rotary() {
            return Translation3::from(self.direction.into_inner() * amount).into();
        }
        let to_axis = Translation3::from(self.through_mm.coords);
        to_axis * UnitQuaternion::from_axis_angle(&self.direction, amount) * to_axis.inverse()
    }

    /// `o_k` in the axes of the carrying component, mm.
    pub(crate) fn error_origin_mm(&self, position: f64) -> Point3<f64> {
        if self.is_rotary() {
            self.through_mm
        } else {
            Point3::from(self.direction.into_inner() * position * self.sense)
        }
    }
}

/// `Dx Dy Dz Da Db Dc` of a twist.
fn displacement(error: &Twist) -> Isometry3<f64> {
    let about = |axis, angle| UnitQuaternion::from_axis_angle(&axis, angle);
    let [a, b, c] = [error.rotation_rad.x, error.rotation_rad.y, error.rotation_rad.z];
    let rotation = about(Vector3::x_axis(), a) * about(Vector3::y_axis(), b) * about(Vector3::z_axis(), c);
    Isometry3::from_parts(Translation3::from(error.translation_mm), rotation)
}
