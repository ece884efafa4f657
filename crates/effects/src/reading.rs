//! What an R-test with its nest on the table reads of an effect, to first order: for golden cases, pictures and comparisons
//! of effects, which need no setup file.
//!
//! R_table⁻¹ (d_tool − d_table), d the displacement of either ball        [docs/design/physics.md §2]

use crate::{Instance, Scene};
use nalgebra::{Point3, Vector3};
use trunnion_core::State;
use trunnion_machine::{JointErrors, Side, Site};

/// Change of the reading, table axes, mm, for one unit of each parameter; the readings of a parameter add.
pub fn r_test_reading(
    instance: &Instance,
    scene: &Scene,
    shape: &[f64],
    state: &State,
    spindle_ball_in_tool_mm: Point3<f64>,
    each: &mut dyn FnMut(usize, Vector3<f64>),
) {
    let none = JointErrors::default();
    let machine_from_table = scene.machine.machine_from_table(&state.position, &none);
    let machine_from_tool = scene.machine.machine_from_tool(&state.position, &none);
    let table_ball =
        machine_from_table * scene.setups.get(state.setup).map_or(Point3::origin(), |s| s.ball_in_table_mm);
    let spindle_ball = machine_from_tool * spindle_ball_in_tool_mm;
    instance.motions(scene, shape, state, &mut |i, site, twist| {
        let tool_against_table = match site {
            Site::Reading => return each(i, twist.translation_mm),
            Site::Instrument(_) => return,
            Site::TableBall => return each(i, -twist.translation_mm),
            Site::SpindleBall => machine_from_tool.rotation * twist.translation_mm,
            Site::Joint(letter) => match scene.machine.joint_frame(letter, &state.position) {
                None => return,
                Some(frame) if scene.machine.side(letter) == Some(Side::Tool) => {
                    frame.displacement_mm(&spindle_ball, &twist)
                }
                Some(frame) => -frame.displacement_mm(&table_ball, &twist),
            },
        };
        each(i, machine_from_table.rotation.inverse() * tool_against_table);
    });
}
