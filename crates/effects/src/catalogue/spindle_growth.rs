//! Growth of the spindle along its axis while it warms up.
//!
//! z(t) = −a (1 − e^(−(t − t₀)/τ)) z_tool at the spindle-side ball: a growing spindle pushes the tool tip out      [docs/design/physics.md §9.12; ISO 230-3 §6]
//! Limits: one change of speed or load at the first point; needs time stamps.

use super::thermal_drift::{TAU_OF_DURATION, warmed_up};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

/// A spindle is at rest while a ball is measured, and grows only when it ran just before: odds of 20:1 against.
const STANDS_STILL_LN: f64 = 3.0;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "spindle-growth",
    role: Role::Cause { price_ln: STANDS_STILL_LN },
    about: About {
        title: "Growth of the spindle",
        source: "docs/design/physics.md §9.12; ISO 230-3 §6",
        equation: "z(t) = −a (1 − e^(−t/τ)) along the spindle",
        symbols: "a final growth, µm; t time since the first point, s; τ time constant, s (shape number tau_s)",
        validity: "One change of spindle heat at the beginning; needs time stamps.",
        typical: "5–30 µm, τ 10–30 min",
        explanation: "The spindle gets longer while it warms up.",
        cause: "Heat of the spindle bearings and motor.",
        seen_by: "Returning to the first pose; only along the tool, unlike thermal drift of the frame.",
        needs: &[Need::TimeStamps],
        helps: &[Need::Return],
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        if scene.has_time() { vec![Parameter::new("growth", Unit::UM)] } else { Vec::new() }
    },
    shapes: |scene: &Scene, _| {
        let duration_s = scene.duration_s().unwrap_or_default();
        Shapes::one("tau_s", TAU_OF_DURATION.map(|share| share * duration_s), true)
    },
    motions,
    example: Example {
        id: "spindle-growth",
        shape: &[900.0],
        values: &[("growth", 20.0)],
        view: View::Time(7200.0),
    },
    golden: Golden {
        source: "IEC 60050-351 (time constant of a first-order lag element: 63.2 % of the final value); ISO 230-3 (spindle growth)",
        derivation: "20 µm final, τ = 900 s: after 900 s the tool tip is 12.64 µm further out, towards −Z.",
        id: "spindle-growth",
        shape: &[900.0],
        values: &[("growth", 20.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { time_s: 900.0, read_um: Some([0.0, 0.0, -12.64]), ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(elapsed_s), &[tau_s]) = (scene.elapsed_s(state), shape) else { return };
    emit(0, Site::SpindleBall, Twist::translation(-Vector3::z() * warmed_up(elapsed_s, tau_s)));
}
