//! Scale error of a linear axis.
//!
//! EXX = s · x on the positioning error, s a ratio             [S2 eq. 1; docs/design/physics.md §5 (0/90° oval), docs/design/physics.md §9.11]
//! Limits: proportional to the coordinate; with one ball radius a common scale of all axes hides.

use crate::subjects::{axis_of, every_linear};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "linear-scale",
    role: Role::CAUSE,
    about: About {
        title: "Scale error of a linear axis",
        source: "S2 eq. 1; ISO 230-2; ISO 230-4",
        equation: "e = s · x on the positioning error",
        symbols: "e positioning error; s ratio, µm/m; x coordinate",
        validity: "Proportional to the coordinate.",
        typical: "10 µm/m",
        explanation: "The axis travels a little too far or too short over its whole length.",
        cause: "Thermal growth of screw or scale, wrong scale factor, screw used as scale without compensation.",
        seen_by: "Two ball radii or a bar of known length; temperature of screw or scale.",
        needs: &[Need::Travel],
        helps: &[Need::TwoRadii, Need::Temperature],
    },
    subjects: every_linear,
    parameters: |scene, subject| match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => vec![Parameter::new("scale", Unit::UM_PER_M)],
        _ => Vec::new(),
    },
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "linear-scale:X",
        shape: &[],
        values: &[("scale", 30.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "ISO 3650 (steel: 11.5 µm/(m·K))",
        derivation: "A steel scale 1 K too warm: 3.45 µm too far at 300 mm.",
        id: "linear-scale:X",
        shape: &[],
        values: &[("scale", 11.5)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 300.0)], read_um: Some([3.45, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", -300.0)], read_um: Some([-3.45, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    emit(0, Site::Joint(axis.letter), axis.positioning_twist() * state.position[axis.letter]);
}
