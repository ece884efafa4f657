//! An R-test reading as displacement of the tool against the table, wherever the nest rides.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use trunnion_core::{NestSide, Point, Setup};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine};

/// What a reading says beyond the nominal machine: tool against table, machine axes, mm.
pub(crate) fn tool_against_table_mm(machine: &Machine, setup: &Setup, point: &Point) -> Vector3<f64> {
    let departure_mm =
        Vector3::from(point.reading_mm) - predict(machine, setup, &point.state, &Errors::default());
    machine_from_reading(machine, setup, point) * departure_mm
}

/// Tool against table in machine axes for a unit of each component of a reading.
pub(crate) fn machine_from_reading(machine: &Machine, setup: &Setup, point: &Point) -> Matrix3<f64> {
    let (position, none) = (&point.state.position, JointErrors::default());
    let turned = |rotation: UnitQuaternion<f64>| rotation.to_rotation_matrix().into_inner();
    match setup.nest {
        NestSide::Table => turned(machine.machine_from_table(position, &none).rotation),
        NestSide::Spindle => -turned(machine.machine_from_tool(position, &none).rotation),
    }
}
