//! The point that the control guides, as the table sees it.

use crate::physics::chain::machine_from_tip;
use nalgebra::Point3;
use trunnion_core::{AxisValues, Twist};
use trunnion_machine::{Machine, Side};

/// A point of the tool in table axes, mm.
pub(super) fn tool_in_table_mm(
    machine: &Machine,
    position: &AxisValues<f64>,
    errors: &AxisValues<Twist>,
    point_in_tool_mm: &Point3<f64>,
) -> Point3<f64> {
    let machine_from_table = machine_from_tip(machine, Side::Table, position, errors);
    machine_from_table.inverse()
        * (machine_from_tip(machine, Side::Tool, position, errors) * point_in_tool_mm)
}
