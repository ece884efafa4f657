//! Radial error motion: the axis line wanders across while it turns.
//!
//! δ(q) = R(+nq) f + R(−nq) b,  f and b across the axis, n = 1…4         [ISO 230-7 §3; S0 §3; docs/design/physics.md §9.3]
//! Every Fourier term of EXC and EYC is a sum of one phasor that turns n times forward and one that turns n times backward.
//! n = 1 forward turns with the table: it *is* the ball setting (or the place of the next axis) and gives no motion here.
//! Limits: repeats every turn.

use crate::subjects::{across, axis_of, every_rotary, linear_name};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::UnitQuaternion;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "radial-error-motion",
    role: Role::Natural,
    about: About {
        title: "Radial error motion",
        source: "ISO 230-7; S0 §3; S4 §4.2.2 and table 2",
        equation: "δ = R(+nq) f + R(−nq) b across the axis, n = 1…4; n = 1 forward is the ball setting",
        symbols: "δ displacement of the axis line, µm; q angle of the axis; f, b phasors that turn forward and backward, µm; n lobes a turn (shape number lobes)",
        validity: "Repeats every turn.",
        typical: "1 µm",
        explanation: "The axis line runs out sideways while it turns.",
        cause: "Bearing run-out: out-of-round rings or rollers of unequal size.",
        seen_by: "Turning the axis with the ball near its line, at two heights; a second ball radius separates n = 1 from a scale error.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights, Need::TwoRadii],
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::one("lobes", (1..=4).map(f64::from), false),
    motions,
    example: Example {
        id: "radial-error-motion:C",
        shape: &[2.0],
        values: &[("EXC.forward", 1.0), ("EXC.backward", 1.0)],
        view: View::Turn,
    },
    golden: Golden {
        source: "ISO 230-7 (radial error motion in a fixed direction, two lobes)",
        derivation: "EXC = 1 µm · cos 2C is half a phasor forward and half backward: +1, 0, −1 µm along machine X at 0, 45, 90°.",
        id: "radial-error-motion:C",
        shape: &[2.0],
        values: &[("EXC.forward", 0.5), ("EXC.backward", 0.5)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([-1.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 45.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 90.0)], read_um: Some([0.0, -1.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.moves(axis.letter)) else {
        return Vec::new();
    };
    let [first, second, _] = across(&axis.direction).index.map(linear_name);
    let name =
        |turn: &str, direction: &str| Parameter::new(format!("E{direction}{}.{turn}", axis.letter), Unit::UM);
    vec![name("forward", first), name("forward", second), name("backward", first), name("backward", second)]
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[n]) = (axis_of(&scene.machine, subject), shape) else { return };
    let site = Site::Joint(axis.letter);
    let across = across(&axis.direction);
    let angle = axis.sense * state.position[axis.letter];
    let forward = UnitQuaternion::from_axis_angle(&axis.direction, n * angle);
    for (k, e) in [across.first, across.second].into_iter().enumerate() {
        if n > 1.0 {
            emit(k, site, Twist::translation(forward * e));
        }
        emit(2 + k, site, Twist::translation(forward.inverse() * e));
    }
}
