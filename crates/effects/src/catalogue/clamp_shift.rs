//! Shift of a rotary axis when its clamp or brake closes.
//!
//! At rest: δ = (EXR, EYR, EZR) and an angle about the axis; moving: nothing            [docs/design/physics.md §9.14; S4 §4.3 axial shift of B]
//! The state has no clamp signal. A clamp that closes at every stop shifts every static reading alike, which is a
//! location error; so the shift exists only against readings in motion, and an axis at rest (no velocity, no
//! acceleration) counts as clamped. Limits: out of reach where the same experiment does not read the axis both
//! at rest and in motion; a clamp that shifts differently each time is scatter, not this effect.

use crate::subjects::{axis_of, every_rotary};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "clamp-shift",
    role: Role::CAUSE,
    about: About {
        title: "Shift when the clamp closes",
        source: "docs/design/physics.md §9.14",
        equation: "at rest: δ = (EXR, EYR, EZR) and a turn about the axis; in motion: 0",
        symbols: "δ shift of the axis in the axes of what carries it, µm; turn about the axis, µrad; at rest = no velocity and no acceleration",
        validity: "There is no clamp signal: the clamp is taken as closed whenever the axis is stationary. Static data alone cannot show it: a shift at every stop is a location error.",
        typical: "1–5 µm",
        explanation: "The axis is pushed aside when its clamp or brake closes.",
        cause: "Clamp or brake that does not pull evenly, drive that lets go before the clamp holds.",
        seen_by: "The same poses at rest and in slow motion, or with the clamp switched off.",
        needs: &[Need::RestAndMotion],
        helps: &[Need::BothDirections, Need::TwoFeeds],
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "clamp-shift:C",
        shape: &[],
        values: &[("EXC", 3.0), ("EZC", 1.5)],
        view: View::StopAndGo,
    },
    golden: Golden {
        source: "BIPM SI Brochure, table 8 (1″ = π/648 000 rad)",
        derivation: "A clamp that turns C by 2″ moves a ball at 150 mm by 1.454 µm along the tangent. It does so while C is clamped, not while C moves.",
        id: "clamp-shift:C",
        shape: &[],
        values: &[("turn", 9.6962736)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, -1.454, 0.0]), ..Moment::AT_REST },
            Moment { velocity: &[("C", 5.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.rests_and_moves(axis.letter))
    else {
        return Vec::new();
    };
    let mut parameters: Vec<_> =
        Joint::LINEAR.map(|letter| Parameter::new(format!("E{letter}{}", axis.letter), Unit::UM)).into();
    parameters.push(Parameter::new("turn", Unit::URAD));
    parameters
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let site = Site::Joint(axis.letter);
    let at_rest = state.velocity[axis.letter] == 0.0 && state.acceleration[axis.letter] == 0.0;
    let clamped = f64::from(u8::from(at_rest));
    for k in 0..3 {
        emit(k, site, Twist::translation(Vector3::ith(k, clamped)));
    }
    emit(3, site, axis.positioning_twist() * clamped);
}
