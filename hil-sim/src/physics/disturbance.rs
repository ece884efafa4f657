//! What is wrong with the machine at one state: the sum of all causes.

use nalgebra::Vector3;
use std::ops::{Add, Mul};
use trunnion_core::{AxisValues, Joint, Twist};
use trunnion_machine::JointErrors;

/// Displacements of the parts of the machine, actual minus nominal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// At each joint, in the nominal axes of the component that carries it.
    pub joints: JointErrors,
    /// Of the tool point, machine axes, mm.
    pub tool_in_machine_mm: Vector3<f64>,
    /// Of the table as a whole, machine axes, mm.
    pub table_in_machine_mm: Vector3<f64>,
    /// Of the ball against the nest, fixed to the table, table axes, mm.
    pub setting_in_table_mm: Vector3<f64>,
}

impl Disturbance {
    /// Only joint errors.
    pub fn from_joints(joints: JointErrors) -> Self {
        Self { joints, ..Self::default() }
    }

    /// Only one joint's error.
    pub fn joint(letter: Joint, twist: Twist) -> Self {
        let mut joints = JointErrors::default();
        joints[letter] = twist;
        Self::from_joints(joints)
    }

    /// Only a displacement of the tool point.
    pub fn tool(tool_in_machine_mm: Vector3<f64>) -> Self {
        Self { tool_in_machine_mm, ..Self::default() }
    }

    /// Only a displacement of the table.
    pub fn table(table_in_machine_mm: Vector3<f64>) -> Self {
        Self { table_in_machine_mm, ..Self::default() }
    }

    /// Only a displacement of ball against nest.
    pub fn setting(setting_in_table_mm: Vector3<f64>) -> Self {
        Self { setting_in_table_mm, ..Self::default() }
    }
}

impl Add for Disturbance {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            joints: AxisValues::from_fn(|letter| self.joints[letter] + other.joints[letter]),
            tool_in_machine_mm: self.tool_in_machine_mm + other.tool_in_machine_mm,
            table_in_machine_mm: self.table_in_machine_mm + other.table_in_machine_mm,
            setting_in_table_mm: self.setting_in_table_mm + other.setting_in_table_mm,
        }
    }
}

impl Mul<f64> for Disturbance {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            joints: AxisValues::from_fn(|letter| self.joints[letter] * factor),
            tool_in_machine_mm: self.tool_in_machine_mm * factor,
            table_in_machine_mm: self.table_in_machine_mm * factor,
            setting_in_table_mm: self.setting_in_table_mm * factor,
        }
    }
}
