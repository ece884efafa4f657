//! How the axes move together while they are read: what a delay can show depends on it.
//!
//! v_rel = Σ_tool J_k v_k − Σ_table J_k v_k, the nominal velocity of spindle-side against table-side ball [docs/design/physics.md §2].
//! An R-test whose linear axes follow the rotary one keeps v_rel = 0: a delay common to all axes moves nothing there.

use crate::SceneSetup;
use nalgebra::{Point3, Vector3};
use trunnion_core::State;
use trunnion_machine::{JointErrors, Machine, Side};

/// Motion of all axes together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Path {
    /// True when a linear and a rotary axis move at the same time.
    pub linear_with_rotary: bool,
    /// True when the nominal motion changes what the instrument reads (also when no setup says so).
    pub changes_reading: bool,
}

/// States looked at, evenly over the experiment.
const LOOKED_AT: usize = 1000;
/// A relative velocity above this share of the velocities it is the difference of is a motion, not rounding.
const SHARE: f64 = 0.02;
/// Slower than this an axis stands, mm/s and rad/s.
const STANDS: f64 = 1e-9;

pub(crate) fn path<'a>(
    machine: &Machine,
    setups: &[SceneSetup],
    states: impl Iterator<Item = &'a State> + Clone,
) -> Path {
    let moving = states.filter(|state| state.velocity.0.iter().any(|v| v.abs() > STANDS));
    let step = moving.clone().count().div_ceil(LOOKED_AT).max(1);
    let mut path = Path::default();
    let (mut seen_mm_s, mut parts_mm_s) = (0.0f64, 0.0f64);
    for state in moving.step_by(step) {
        let any = |rotary| {
            machine
                .axes()
                .any(|axis| axis.is_rotary() == rotary && state.velocity[axis.letter].abs() > STANDS)
        };
        path.linear_with_rotary |= any(true) && any(false);
        match setups.get(state.setup) {
            None => path.changes_reading = true,
            Some(setup) => {
                let (seen, part) = relative_speed_mm_s(machine, setup, state);
                seen_mm_s = seen_mm_s.max(seen);
                parts_mm_s = parts_mm_s.max(part);
            }
        }
    }
    path.changes_reading |= seen_mm_s > SHARE * parts_mm_s;
    path
}

/// Speed that the instrument sees, and the largest share one axis has in it.
fn relative_speed_mm_s(machine: &Machine, setup: &SceneSetup, state: &State) -> (f64, f64) {
    let none = JointErrors::default();
    let table_ball = machine.machine_from_table(&state.position, &none) * setup.ball_in_table_mm;
    let spindle_ball = machine.machine_from_tool(&state.position, &none) * Point3::origin();
    let (mut relative, mut largest) = (Vector3::zeros(), 0.0f64);
    for axis in machine.axes() {
        let Some(frame) = machine.joint_frame(axis.letter, &state.position) else { continue };
        let twist = axis.positioning_twist() * state.velocity[axis.letter];
        let part = match machine.side(axis.letter) {
            Some(Side::Tool) => frame.displacement_mm(&spindle_ball, &twist),
            _ => -frame.displacement_mm(&table_ball, &twist),
        };
        relative += part;
        largest = largest.max(part.norm());
    }
    let along_bar = (spindle_ball - table_ball).try_normalize(1e-9).filter(|_| setup.components.len() == 1);
    (along_bar.map_or(relative.norm(), |bar| bar.dot(&relative).abs()), largest)
}
