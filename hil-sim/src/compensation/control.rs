//! What other controls hold: lines of the rotary axes, and tables that move one axis over another.
//!
//! `table_from_tool(q', lines)·t = table_from_tool(q, nominal)·t`, t the point of the tool that the control guides, then every output axis moves by minus the value of its tables.
//! The lines replace those of the nominal machine, so that the control turns about them.

use super::tool_point::tool_in_table_mm;
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::{Axis, Machine};

/// Newton steps, as in [`super`].
const STEPS: usize = 3;

/// What a control holds of its five-axis transformation and of tables.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Control {
    /// How far the lines of the rotary axes were moved: axis, its point in mm, its direction.
    pub(super) lines: Vec<(Joint, Vector3<f64>, Vector3<f64>)>,
    /// Tables: output moves by minus the value at the position of the input.
    pub(super) tables: Vec<Cross>,
}

/// A table of a control.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cross {
    pub input: Joint,
    pub output: Joint,
    /// First position, mm or rad.
    pub first: f64,
    /// Step between rows, mm or rad.
    pub step: f64,
    /// mm or rad.
    pub values: Vec<f64>,
    pub modulo: bool,
}

impl Control {
    /// Where the axes really go when `position` is commanded under tool centre point control.
    pub(super) fn corrected(
        &self,
        machine: &Machine,
        position: &AxisValues<f64>,
        point_in_tool_mm: &Point3<f64>,
    ) -> Option<AxisValues<f64>> {
        let none = AxisValues::default();
        let believed = self.believed(machine);
        let wanted = tool_in_table_mm(machine, position, &none, point_in_tool_mm);
        let mut corrected = *position;
        for _ in 0..STEPS {
            let here = tool_in_table_mm(&believed, &corrected, &none, point_in_tool_mm);
            let mut slope = Matrix3::zeros();
            for (i, letter) in Joint::LINEAR.into_iter().enumerate() {
                let mut moved = corrected;
                moved[letter] += 1.0;
                slope.set_column(i, &(tool_in_table_mm(&believed, &moved, &none, point_in_tool_mm) - here));
            }
            let step: Vector3<f64> = slope.try_inverse()? * (wanted - here);
            for (i, letter) in Joint::LINEAR.into_iter().enumerate() {
                corrected[letter] += step[i];
            }
        }
        let mut driven = corrected;
        for table in &self.tables {
            driven[table.output] -= table.at(corrected[table.input]);
        }
        Some(driven)
    }

    /// The machine as the control believes it to be.
    fn believed(&self, machine: &Machine) -> Machine {
        let mut believed = machine.clone();
        let axes: Vec<&mut Axis> = believed.table.iter_mut().chain(&mut believed.tool).collect();
        for axis in axes {
            for (_, moved_mm, turned) in self.lines.iter().filter(|(letter, ..)| *letter == axis.letter) {
                axis.through_mm += moved_mm;
                axis.direction = Unit::new_normalize(axis.direction.into_inner() + turned);
            }
        }
        believed
    }
}

impl Cross {
    /// Straight lines between the rows, the end values beyond them.
    fn at(&self, position: f64) -> f64 {
        let last = self.values.len() - 1;
        let mut place = (position - self.first) / self.step;
        if self.modulo {
            place = place.rem_euclid(last as f64);
        }
        let place = place.clamp(0.0, last as f64);
        let row = (place as usize).min(last.saturating_sub(1));
        let share = place - row as f64;
        self.values[row] * (1.0 - share) + self.values[(row + 1).min(last)] * share
    }
}
