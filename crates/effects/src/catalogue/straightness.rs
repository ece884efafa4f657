//! Straightness errors of a linear axis: bow and S-shape, both lateral directions.
//!
//! EYX(x) = a₂ P₂(s) + a₃ P₃(s), s = x scaled to −1…1 over the measured range, P₂, P₃ Legendre        [S2 eq. 1; docs/design/physics.md §5 (three lobes), docs/design/physics.md §9.11]
//! The straight part is squareness. Limits: smooth guideway; the amplitude belongs to the measured range.

use crate::legendre::legendre;
use crate::subjects::{across, axis_of, every_slide, linear_name};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "straightness",
    role: Role::CAUSE,
    about: About {
        title: "Straightness of a linear axis",
        source: "S2 eq. 1; S4 table 2 (straightness); ISO 230-1",
        equation: "e = a₂ P₂(s) + a₃ P₃(s) across the axis, s = −1…1 over the measured range",
        symbols: "e displacement across the axis, µm; a₂, a₃ amplitudes, µm; P₂, P₃ Legendre polynomials; s coordinate scaled to −1…1",
        validity: "Smooth guideway; orders 2 and 3 over the measured range.",
        typical: "1–5 µm",
        explanation: "The axis travels along a bow or an S instead of a straight line.",
        cause: "Guideway bent by assembly, by its own weight or by heat.",
        seen_by: "Poses all along the axis; other balls or bar lengths separate it from rotary errors.",
        needs: &[Need::Travel],
        helps: &[Need::TwoRadii],
    },
    subjects: every_slide,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "straightness:X",
        shape: &[],
        values: &[("EYX.P3", 3.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "Abramowitz & Stegun table 8.1 (P₃(0.5) = −0.4375)",
        derivation: "8 µm of P₃ over −200…200 mm: ±8 µm at the ends, −3.5 µm at three quarters of the range.",
        id: "straightness:X",
        shape: &[],
        values: &[("EYX.P3", 8.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { position: &[("X", -200.0)], read_um: Some([0.0, -8.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 100.0)], read_um: Some([0.0, -3.5, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 200.0)], read_um: Some([0.0, 8.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};

/// Coordinate scaled to −1…1 over the measured range of the axis.
pub(super) fn scaled(scene: &Scene, letter: Joint, state: &State) -> f64 {
    let (low, high) = scene.position_range[letter];
    if high > low { (2.0 * state.position[letter] - low - high) / (high - low) } else { 0.0 }
}

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.moves(axis.letter)) else {
        return Vec::new();
    };
    let [first, second, _] = across(&axis.direction).index.map(linear_name);
    [first, second]
        .into_iter()
        .flat_map(|k| [2, 3].map(|n| Parameter::new(format!("E{k}{}.P{n}", axis.letter), Unit::UM)))
        .collect()
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let (s, across) = (scaled(scene, axis.letter, state), across(&axis.direction));
    let [_, _, p2, p3] = legendre(s);
    for (k, e) in [across.first, across.second].into_iter().enumerate() {
        emit(2 * k, Site::Joint(axis.letter), Twist::translation(e * p2));
        emit(2 * k + 1, Site::Joint(axis.letter), Twist::translation(e * p3));
    }
}
