//! Cyclic error of a ball screw or linear scale.
//!
//! e(x) = a cos(2πx/p) + b sin(2πx/p) on the positioning error, p the period        [docs/design/physics.md §9.10; ISO 230-4 cyclic error]
//! p: any period that the residual shows; lead and half the lead of the machine file, or a list of usual leads, are tried in any case.
//! Limits: aliases on coarse grids of poses.

use crate::subjects::{axis_of, every_linear};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
    WaveNumber,
};
use std::f64::consts::TAU;
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "ballscrew-pitch",
    role: Role::CAUSE,
    about: About {
        title: "Cyclic error of the ball screw",
        source: "docs/design/physics.md §5, §9.10; ISO 230-4",
        equation: "e = a cos(2πx/p) + b sin(2πx/p); p any",
        symbols: "e positioning error, µm; a, b amplitudes, µm; x coordinate, mm; p period, mm (shape number period_mm)",
        validity: "Same at every turn of the screw; aliases on a coarse grid of poses.",
        typical: "0.5–3 µm",
        explanation: "The axis runs ahead and behind in a wave along its travel, the same at every turn of its screw.",
        cause: "Once a turn: screw or its bearing running out, eccentric motor encoder, coupling out of line; several times a turn: pole pairs of motor or resolver; else the pitch of the scale.",
        seen_by: "A slow continuous move, or poses much closer than the lead.",
        needs: &[Need::Travel],
        helps: &[Need::FinerStep],
    },
    subjects: every_linear,
    parameters,
    shapes,
    motions,
    example: Example {
        id: "ballscrew-pitch:X",
        shape: &[12.0],
        values: &[("cos", 2.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "JIS B 1192 (ball screws; e₂π, variation of travel in one turn, grade C5: 8 µm)",
        derivation: "8 µm from crest to trough within a lead of 12 mm: ±4 µm half a lead apart, and again a lead later.",
        id: "ballscrew-pitch:X",
        shape: &[12.0],
        values: &[("cos", 4.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([4.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 3.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 6.0)], read_um: Some([-4.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 12.0)], read_um: Some([4.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => {
            ["cos", "sin"].map(|name| Parameter::new(name, Unit::UM)).into()
        }
        _ => Vec::new(),
    }
}

fn shapes(scene: &Scene, subject: Subject) -> Shapes {
    let axis = axis_of(&scene.machine, subject);
    let periods_mm = match axis.and_then(|axis| axis.facts.screw_lead_mm) {
        Some(lead_mm) => vec![lead_mm, lead_mm / 2.0],
        None => vec![4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 32.0, 40.0],
    };
    let known = Shapes::one("period_mm", periods_mm, false);
    match axis {
        Some(axis) => known.waving(WaveNumber::Period(axis.letter)),
        None => known,
    }
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[period_mm]) = (axis_of(&scene.machine, subject), shape) else { return };
    let phase = TAU * state.position[axis.letter] / period_mm;
    emit(0, Site::Joint(axis.letter), axis.positioning_twist() * phase.cos());
    emit(1, Site::Joint(axis.letter), axis.positioning_twist() * phase.sin());
}
