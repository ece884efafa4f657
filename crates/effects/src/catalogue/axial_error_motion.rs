//! Axial error motion: the turning part moves along its axis.
//!
//! δ(q) = (a cos nq + b sin nq) along the axis, n = 1…4                    [ISO 230-7 §3; S4 §4.2.2]
//! Limits: repeats every turn.

use crate::subjects::{axis_of, every_rotary};
use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "axial-error-motion",
    role: Role::Natural,
    about: About {
        title: "Axial error motion",
        source: "ISO 230-7; S4 §4.2.2 (measurement C-Z) and table 2",
        equation: "δ = (a cos nq + b sin nq) along the axis, n = 1…4",
        symbols: "δ displacement along the axis, µm; q angle of the axis; a, b amplitudes, µm; n lobes a turn (shape number lobes)",
        validity: "Repeats every turn.",
        typical: "1 µm",
        explanation: "The table rises and falls while it turns.",
        cause: "Axial run-out of the bearing: wavy rings, rollers of unequal size.",
        seen_by: "Turning the axis with the ball on its line (one radius separates it from a tilt only for n > 1).",
        needs: &[Need::Travel],
        helps: &[Need::TwoRadii],
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::one("lobes", (1..=4).map(f64::from), false),
    motions,
    example: Example { id: "axial-error-motion:C", shape: &[2.0], values: &[("cos", 1.0)], view: View::Turn },
    golden: Golden {
        source: "ISO 230-7 (axial error motion value: largest minus smallest)",
        derivation: "Two lobes with a value of 2 µm: the table is 1 µm up at C = 0 and 180°, 1 µm down at ±90°.",
        id: "axial-error-motion:C",
        shape: &[2.0],
        values: &[("cos", 1.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, -1.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 90.0)], read_um: Some([0.0, 0.0, 1.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 180.0)], read_um: Some([0.0, 0.0, -1.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};

/// Bearings of rotary tables run out by some micrometres, axially and radially; ten times the worst of these is no bearing. A judgement, tuned
/// on no data.
pub(super) const RUN_OUT: Limit = Limit {
    largest: 100.0,
    beyond: "no bearing that still turns runs out so far; something else that comes back at every turn is behind it",
    resembles: false,
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => {
            ["cos", "sin"].map(|name| Parameter::new(name, Unit::UM).at_most(RUN_OUT)).into()
        }
        _ => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[n]) = (axis_of(&scene.machine, subject), shape) else { return };
    let (q, site, along) =
        (state.position[axis.letter], Site::Joint(axis.letter), axis.direction.into_inner());
    emit(0, site, Twist::translation(along * (n * q).cos()));
    emit(1, site, Twist::translation(along * (n * q).sin()));
}
