//! The linear rule: how a small twist at one joint moves a point that the joint carries.
//!
//! `d(p) = R δ + (R ω) × (p − o)` [METHODS §2], R and o the nominal axes and origin of the joint in the
//! machine frame, p in the machine frame. The sign by which `d` enters a reading belongs to the instrument:
//! tool side +, table side − when the table carries the nest.

use crate::{JointErrors, Machine};
use nalgebra::{Point3, UnitQuaternion, Vector3};
use trunnion_units::{AxisLetter, AxisValues, Twist};

/// Nominal place of a joint's error in the machine frame.
#[derive(Clone, Copy, Debug)]
pub struct JointFrame {
    /// R: machine axes from the axes of the component that carries the joint.
    pub machine_from_carrier: UnitQuaternion<f64>,
    /// o: where the joint's angular errors pivot, in machine coordinates, mm.
    pub origin_in_machine_mm: Point3<f64>,
}

impl JointFrame {
    /// Displacement of a carried point, machine axes, mm.
    pub fn displacement_mm(&self, point_in_machine_mm: &Point3<f64>, twist: &Twist) -> Vector3<f64> {
        let delta = self.machine_from_carrier * twist.translation_mm;
        let omega = self.machine_from_carrier * twist.rotation_rad;
        delta + omega.cross(&(point_in_machine_mm - self.origin_in_machine_mm))
    }
}

impl Machine {
    /// The nominal frame of a joint; `None` when the machine has no such axis.
    pub fn joint_frame(&self, letter: AxisLetter, position: &AxisValues<f64>) -> Option<JointFrame> {
        let side = self.side(letter)?;
        let mut machine_from_carrier = nalgebra::Isometry3::identity();
        for axis in self.from_bed(side) {
            if axis.letter == letter {
                return Some(JointFrame {
                    machine_from_carrier: machine_from_carrier.rotation,
                    origin_in_machine_mm: machine_from_carrier * axis.error_origin_mm(position[letter]),
                });
            }
            machine_from_carrier *= axis.motion(position[axis.letter]);
        }
        None
    }

    /// Sum of the linear displacements of a point fixed to the table or to the tool, machine axes, mm.
    pub fn linear_displacement_mm(
        &self,
        side: crate::Side,
        position: &AxisValues<f64>,
        point_in_machine_mm: &Point3<f64>,
        errors: &JointErrors,
    ) -> Vector3<f64> {
        self.from_bed(side)
            .into_iter()
            .filter_map(|axis| {
                let frame = self.joint_frame(axis.letter, position)?;
                Some(frame.displacement_mm(point_in_machine_mm, &errors[axis.letter]))
            })
            .sum()
    }
}

#[cfg(test)]
mod tests;
