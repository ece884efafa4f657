//! Volumetric compensation as a controller does it: the axes go elsewhere, so that the tool point is where it should be.
//!
//! The controller holds the table e(q) of joint errors and, for a commanded q, looks for linear axes q' with
//! `table_from_tool(q', e(q'))·t = table_from_tool(q, 0)·t`, the point t of the tool in table axes. The positions on its screen stay
//! the commanded ones. Orientation is left as it is. Reading the files and moving the axes share no code with the estimator.

mod control;
mod control_files;
mod numbers;
mod read;
mod tool_point;

use control::Control;
use nalgebra::{Matrix3, Point3, Vector3};
use tool_point::tool_in_table_mm;
use trunnion_core::{AxisValues, Joint, Twist};
use trunnion_machine::Machine;

/// Newton steps; errors are small, so that the second changes nothing that could be seen.
const STEPS: usize = 3;
/// A table that spans a whole turn this closely goes on periodically, rad.
const TURN_TOLERANCE: f64 = 1e-6;

/// What the controller believes of its axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Compensation {
    /// Constant joint errors, mm and rad.
    location: AxisValues<Twist>,
    /// Joint errors over the position of the joint.
    tables: Vec<Table>,
    /// What the control holds in place of joint errors: lines of its transformation, tables of axes.
    control: Option<Control>,
}

/// Component errors of one axis.
#[derive(Clone, Debug, PartialEq)]
struct Table {
    axis: Joint,
    /// mm or rad, rising.
    positions: Vec<f64>,
    /// As many, mm and rad.
    errors: Vec<Twist>,
}

/// A machine whose controller cannot correct the tool point.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("machine {machine} cannot correct its tool point in three directions; it needs three linear axes")]
pub struct CannotCorrect {
    machine: String,
}

impl Compensation {
    /// Joint errors the controller expects at a commanded position.
    pub fn errors_at(&self, position: &AxisValues<f64>) -> AxisValues<Twist> {
        let mut errors = self.location;
        for table in &self.tables {
            errors[table.axis] += table.at(position[table.axis]);
        }
        errors
    }

    /// Where the axes really go when `position` is commanded; `None` when the linear axes cannot.
    /// `point_in_tool_mm` is the point that the control guides: the tool of this length.
    pub fn corrected(
        &self,
        machine: &Machine,
        position: &AxisValues<f64>,
        point_in_tool_mm: &Point3<f64>,
    ) -> Option<AxisValues<f64>> {
        if let Some(control) = &self.control {
            return control.corrected(machine, position, point_in_tool_mm);
        }
        let none = AxisValues::default();
        let wanted = tool_in_table_mm(machine, position, &none, point_in_tool_mm);
        let mut corrected = *position;
        for _ in 0..STEPS {
            let errors = self.errors_at(&corrected);
            let gap = wanted - tool_in_table_mm(machine, &corrected, &errors, point_in_tool_mm);
            let mut slope = Matrix3::zeros();
            for (i, letter) in Joint::LINEAR.into_iter().enumerate() {
                let mut moved = corrected;
                moved[letter] += 1.0;
                let travel = tool_in_table_mm(machine, &moved, &none, point_in_tool_mm)
                    - tool_in_table_mm(machine, &corrected, &none, point_in_tool_mm);
                slope.set_column(i, &travel);
            }
            let step: Vector3<f64> = slope.try_inverse()? * gap;
            for (i, letter) in Joint::LINEAR.into_iter().enumerate() {
                corrected[letter] += step[i];
            }
        }
        Some(corrected)
    }

    /// # Errors
    /// When the machine's linear axes cannot move the tool point in all directions.
    pub(crate) fn fits(&self, machine: &Machine) -> Result<(), CannotCorrect> {
        match self.corrected(machine, &AxisValues::default(), &Point3::origin()) {
            Some(_) => Ok(()),
            None => Err(CannotCorrect { machine: machine.name.clone() }),
        }
    }
}

impl Table {
    /// Straight lines between the rows; beyond the ends the end values, unless it is a whole turn.
    fn at(&self, position: f64) -> Twist {
        let (first, last) = (self.positions[0], self.positions[self.positions.len() - 1]);
        let turn = std::f64::consts::TAU;
        let whole = self.axis.is_rotary() && (last - first - turn).abs() < TURN_TOLERANCE;
        let here = if whole { first + (position - first).rem_euclid(turn) } else { position };
        let here = here.clamp(first, last);
        let above = self.positions.partition_point(|row| *row <= here).clamp(1, self.positions.len() - 1);
        let (low, high) = (self.positions[above - 1], self.positions[above]);
        let share = (here - low) / (high - low);
        self.errors[above - 1] * (1.0 - share) + self.errors[above] * share
    }
}
