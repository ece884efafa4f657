//! The axis line of a rotary axis shifts with the direction of rotation.
//!
//! δ = ½ s · direction, s = (X, Y, Z) in the carrier of the axis        [docs/design/physics.md §9.6; S4 §4.3: 2 µm axial on reversing B]
//! Limits: direction known; both directions measured.

use crate::subjects::{axis_of, every_rotary};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "direction-shift",
    role: Role::CAUSE,
    about: About {
        title: "Shift of the axis with the direction of rotation",
        source: "S4 §4.3 (2 µm axial shift of B on reversal); docs/design/physics.md §9.6",
        equation: "δ = ½ s · direction, s = (EXR, EYR, EZR)",
        symbols: "δ displacement of the axis line, µm; s shift between the two directions in the axes of what carries it, µm; direction −1, 0, +1",
        validity: "The direction of rotation is known and both occur.",
        typical: "2 µm",
        explanation: "The whole axis moves a little sideways or lengthways when it turns the other way.",
        cause: "Bearing without enough preload, pushed by the worm or by friction.",
        seen_by: "Both directions of this axis at every pose.",
        needs: &[Need::Travel, Need::BothDirections],
        helps: &[Need::TwoHeights],
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "direction-shift:C",
        shape: &[],
        values: &[("EXC", 2.0), ("EZC", 1.0)],
        view: View::Turn,
    },
    golden: Golden {
        source: "S4 §4.3 (measurement B-Y: 2 µm axial displacement when B changes its direction)",
        derivation: "The table side shifts by ±1 µm along Y about the mean of both directions.",
        id: "direction-shift:B",
        shape: &[],
        values: &[("EYB", 2.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment {
                position: &[("B", 30.0)],
                direction: &[("B", 1.0)],
                read_um: Some([0.0, -1.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("B", 30.0)],
                direction: &[("B", -1.0)],
                read_um: Some([0.0, 1.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment { position: &[("B", -30.0)], ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) && scene.both_directions(axis.letter) => {
            Joint::LINEAR.map(|letter| Parameter::new(format!("E{letter}{}", axis.letter), Unit::UM)).into()
        }
        _ => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    for k in 0..3 {
        let half_shift = Vector3::ith(k, 0.5 * state.direction[axis.letter]);
        emit(k, Site::Joint(axis.letter), Twist::translation(half_shift));
    }
}
