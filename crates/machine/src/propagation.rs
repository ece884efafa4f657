//! The linear rule: how a small twist at one joint moves a point that the joint carries.
//!
//! `d(p) = R δ + (R ω) × (p − o)` [docs/design/physics.md §2.1], R and o the nominal axes and origin of the joint in the
//! machine frame, p in the machine frame. The sign by which `d` enters a reading belongs to the instrument:
//! tool side +, table side − when the table carries the nest. The stroke of a leg moves the platform by the Jacobian of
//! [`crate::tripod`] instead.

use crate::tripod::LegMotion;
use crate::{JointErrors, Machine, Site};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trunnion_core::{AxisValues, Joint, Twist};

/// Nominal place of a joint's error in the machine frame.
#[derive(Clone, Copy, Debug)]
pub struct JointFrame {
    /// R: machine axes from the axes of the component that carries the joint.
    pub machine_from_carrier: UnitQuaternion<f64>,
    /// o: where the joint's angular errors pivot, in machine coordinates, mm.
    pub origin_in_machine_mm: Point3<f64>,
    /// Set for the stroke of a leg, whose error moves the platform.
    pub leg: Option<LegMotion>,
}

impl JointFrame {
    /// Displacement of a carried point, machine axes, mm.
    pub fn displacement_mm(&self, point_in_machine_mm: &Point3<f64>, twist: &Twist) -> Vector3<f64> {
        let moved = self.turned(twist);
        moved.translation_mm + moved.rotation_rad.cross(&(point_in_machine_mm - self.origin_in_machine_mm))
    }

    /// The twist of what the joint carries, machine axes, at its origin.
    pub fn turned(&self, twist: &Twist) -> Twist {
        if let Some(leg) = &self.leg {
            let stroke_mm = twist.translation_mm.dot(&leg.along);
            return Twist {
                translation_mm: leg.velocity * stroke_mm,
                rotation_rad: leg.turning_rad_per_mm * stroke_mm,
            };
        }
        Twist {
            translation_mm: self.machine_from_carrier * twist.translation_mm,
            rotation_rad: self.machine_from_carrier * twist.rotation_rad,
        }
    }
}

impl Machine {
    /// The nominal frame of a joint; `None` when the machine has no such axis.
    pub fn joint_frame(&self, letter: Joint, position: &AxisValues<f64>) -> Option<JointFrame> {
        let side = self.side(letter)?;
        if let Some(tripod) = self.tripod.as_ref().filter(|tripod| tripod.has(letter)) {
            let leg = tripod.leg_motion(letter, position)?;
            return Some(JointFrame {
                machine_from_carrier: UnitQuaternion::identity(),
                origin_in_machine_mm: leg.origin_in_machine_mm,
                leg: Some(leg),
            });
        }
        let mut machine_from_carrier = self.platform(side, position, &JointErrors::default());
        for axis in self.from_bed(side).into_iter().filter(|axis| !self.is_leg(axis.letter)) {
            if axis.letter == letter {
                return Some(JointFrame {
                    machine_from_carrier: machine_from_carrier.rotation,
                    origin_in_machine_mm: machine_from_carrier * axis.error_origin_mm(position[letter]),
                    leg: None,
                });
            }
            machine_from_carrier *= axis.motion(position[axis.letter]);
        }
        None
    }
}

impl Machine {
    /// A site that moves the whole tool side, and its axes from machine axes: a joint on the bed, or the first joint on the
    /// platform of a hybrid machine.
    pub fn whole_tool_side(&self, position: &AxisValues<f64>) -> (Site, UnitQuaternion<f64>) {
        let in_series = self.tool.iter().find(|axis| !self.is_leg(axis.letter));
        let carrier_from_machine =
            |letter| Some(self.joint_frame(letter, position)?.machine_from_carrier.inverse());
        match in_series {
            None => (Site::SpindleBall, self.tool_from_machine(position)),
            Some(axis) => (Site::Joint(axis.letter), carrier_from_machine(axis.letter).unwrap_or_default()),
        }
    }

    fn tool_from_machine(&self, position: &AxisValues<f64>) -> UnitQuaternion<f64> {
        self.machine_from_tool(position, &JointErrors::default()).rotation.inverse()
    }
}

#[cfg(test)]
mod tests;
