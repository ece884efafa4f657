//! Error motion of a rotary axis across its line, as phasors that turn with it and against it.
//!
//! e(q) = R(+nq) f + R(−nq) b,  f and b across the axis, n lobes a turn                      [ISO 230-7 §3; docs/design/physics.md §9.3]
//! n = 1 forward turns with the table: to the ball it is part of its setting and gives no motion here.

use crate::subjects::{across, axis_of};
use crate::{Emit, Parameter, Scene, Subject, Unit};
use nalgebra::{UnitQuaternion, Vector3};
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

/// Both components of f, then of b, in `unit`; `letter_of` names the directions across the axis.
pub(crate) fn parameters(
    scene: &Scene,
    subject: Subject,
    letter_of: fn(usize) -> &'static str,
    unit: Unit,
) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.moves(axis.letter)) else {
        return Vec::new();
    };
    let [first, second, _] = across(&axis.direction).index.map(letter_of);
    let name =
        |turn: &str, direction: &str| Parameter::new(format!("E{direction}{}.{turn}", axis.letter), unit);
    vec![name("forward", first), name("forward", second), name("backward", first), name("backward", second)]
}

/// Motions of a unit of each parameter; `shape` is n, and `twist_of` makes a motion of a vector across the axis.
pub(crate) fn motions(
    scene: &Scene,
    subject: Subject,
    shape: &[f64],
    state: &State,
    twist_of: fn(Vector3<f64>) -> Twist,
    emit: Emit<'_>,
) {
    let (Some(axis), &[n]) = (axis_of(&scene.machine, subject), shape) else { return };
    let site = Site::Joint(axis.letter);
    let across = across(&axis.direction);
    let angle = axis.sense * state.position[axis.letter];
    let forward = UnitQuaternion::from_axis_angle(&axis.direction, n * angle);
    for (k, e) in [across.first, across.second].into_iter().enumerate() {
        if n > 1.0 {
            emit(k, site, twist_of(forward * e));
        }
        emit(2 + k, site, twist_of(forward.inverse() * e));
    }
}
