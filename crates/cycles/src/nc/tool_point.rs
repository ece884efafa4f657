//! Positions under tool centre point control.
//!
//! The programmed position is where the linear axes bring the tool point to the same place of the table with the rotary axes at zero: the work
//! offset is fixed on the table, and turns with it from where the control was switched on [FANUC A-79348E p. 19]. So it is switched on there.

use crate::{Cycle, VisitError};
use nalgebra::Point3;
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::{JointErrors, Machine};

/// The rotary axes as they are, the linear ones as programmed.
pub(super) fn programmed(machine: &Machine, at: &AxisValues<f64>) -> Option<AxisValues<f64>> {
    let mut position = turned(machine, at, &AxisValues::default())?;
    Joint::ROTARY.into_iter().for_each(|letter| position[letter] = at[letter]);
    Some(position)
}

/// The rotary axes as in `to`, the tool point at the place of the table where it is at `at`.
pub(super) fn turned(
    machine: &Machine,
    at: &AxisValues<f64>,
    to: &AxisValues<f64>,
) -> Option<AxisValues<f64>> {
    let none = JointErrors::default();
    let tool_in_table = machine.machine_from_table(at, &none).inverse()
        * (machine.machine_from_tool(at, &none) * Point3::origin());
    machine.follow(to, &tool_in_table)
}

/// # Errors
/// A machine on which tool centre point control does nothing, or that cannot stand where it is switched on.
pub(super) fn possible(cycle: &Cycle, machine: &Machine) -> Result<(), VisitError> {
    let refused = |what| Err(VisitError::NoCourse { cycle: cycle.name.clone(), what });
    let rotary = machine.rotary();
    if rotary.is_empty() {
        return refused("its machine has no rotary axis, so tool centre point control does nothing");
    }
    if rotary.iter().any(|axis| axis.travel.0 > 0.0 || axis.travel.1 < 0.0) {
        return refused("a rotary axis does not reach zero, where tool centre point control is switched on");
    }
    Ok(())
}
