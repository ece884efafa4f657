//! Pitch, yaw and roll of a linear axis.
//!
//! EAX(x) = a₁ s + a₂ P₂(s) and likewise EBX, ECX, s = x scaled to −1…1 over the measured range      [S2 eq. 1–2; S4 table 2]
//! They act about the carriage, with the arm to the tool point or the ball. Limits: smooth guideway.

use super::straightness::scaled;
use crate::legendre::legendre;
use crate::subjects::{axis_of, every_slide};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "angular-motion",
    role: Role::CAUSE,
    about: About {
        title: "Pitch, yaw and roll of a linear axis",
        source: "S2 eq. 1–2; S4 table 2 (pitch, yaw, roll changes)",
        equation: "EAX = a₁ s + a₂ P₂(s), likewise EBX, ECX; s = −1…1 over the measured range",
        symbols: "EAX, EBX, ECX turns of the carriage, µrad; a₁, a₂ amplitudes, µrad; P₂ Legendre polynomial; s coordinate scaled to −1…1",
        validity: "Smooth guideway; orders 1 and 2 over the measured range.",
        typical: "10–30 µrad",
        explanation: "The carriage nods, swings or rolls while it travels.",
        cause: "Guideways not parallel or bent; weight of the carriage overhanging the bed.",
        seen_by: "Poses all along the axis with other axes at different places, so that the arm changes; two tool lengths.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights],
    },
    subjects: every_slide,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "angular-motion:X",
        shape: &[],
        values: &[("EBX.P1", 20.0), ("ECX.P2", 20.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "S2 eq. 1 (ey = −EAX · z); Abbe's principle",
        derivation: "A roll of 20 µrad at the end of the range moves a tool 100 mm above the carriage by 2 µm towards −Y.",
        id: "angular-motion:X",
        shape: &[],
        values: &[("EAX.P1", 20.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment {
                position: &[("X", -200.0), ("Z", 100.0)],
                read_um: Some([0.0, 2.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("X", 200.0), ("Z", 100.0)],
                read_um: Some([0.0, -2.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment { position: &[("X", 200.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.moves(axis.letter)) else {
        return Vec::new();
    };
    Joint::ROTARY
        .into_iter()
        .flat_map(|k| [1, 2].map(|n| Parameter::new(format!("E{k}{}.P{n}", axis.letter), Unit::URAD)))
        .collect()
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let s = scaled(scene, axis.letter, state);
    let [_, p1, p2] = legendre(s);
    for k in 0..3 {
        emit(2 * k, Site::Joint(axis.letter), Twist::rotation(Vector3::ith(k, p1)));
        emit(2 * k + 1, Site::Joint(axis.letter), Twist::rotation(Vector3::ith(k, p2)));
    }
}
