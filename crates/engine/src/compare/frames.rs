//! The residual of a point in machine axes and in the axes of the table.

use crate::Experiment;
use crate::noise::machine_noise::ground_joint;
use nalgebra::{DVector, Matrix3, Vector3};
use trunnion_core::Twist;
use trunnion_instruments::Projector;
use trunnion_machine::Side;

/// The residual of a point as motion of the tool against the table in machine axes, mm, and the rotation from machine to
/// table axes; `None` where the instrument reads one component.
pub fn in_frames(
    experiment: &Experiment,
    residual_mm: &DVector<f64>,
    point: usize,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let rows = experiment.rows_of(point);
    if rows.len() != 3 {
        return None;
    }
    let reading =
        Vector3::new(residual_mm[rows.start], residual_mm[rows.start + 1], residual_mm[rows.start + 2]);
    let state = &experiment.points[point].state;
    let machine = experiment.machine();
    let projector = Projector::new(machine, &experiment.setups[state.setup], state);
    let (ground, into_ground) = ground_joint(machine, &state.position);
    let unit = |k: usize| projector.column(ground, &Twist::translation(into_ground * Vector3::ith(k, 1.0)));
    // The columns are those of a rotation up to the side of the nest; a joint of the table moves the tool the other way.
    let towards_tool = if machine.from_bed(Side::Tool).is_empty() { -1.0 } else { 1.0 };
    let nest_from_machine = Matrix3::from_columns(&[unit(0), unit(1), unit(2)]);
    let in_machine = nest_from_machine.transpose() * reading * towards_tool;
    let machine_from_table = machine.machine_from_table(&state.position, &Default::default()).rotation;
    Some((in_machine, machine_from_table.inverse().to_rotation_matrix().into_inner()))
}
