//! An R-test reading as displacement of the tool against the table, wherever the nest rides.

use nalgebra::Vector3;
use trunnion_core::{NestSide, Point, Setup};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine};

/// What a reading says beyond the nominal machine: tool against table, machine axes, mm.
pub(crate) fn tool_against_table_mm(machine: &Machine, setup: &Setup, point: &Point) -> Vector3<f64> {
    let (position, none) = (&point.state.position, JointErrors::default());
    let departure_mm =
        Vector3::from(point.reading_mm) - predict(machine, setup, &point.state, &Errors::default());
    match setup.nest {
        NestSide::Table => machine.machine_from_table(position, &none).rotation * departure_mm,
        NestSide::Spindle => machine.machine_from_tool(position, &none).rotation * -departure_mm,
    }
}
