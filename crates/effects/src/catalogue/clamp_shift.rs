//! Shift of a rotary axis when its clamp or brake closes.
//!
//! At rest: δ = (EXR, EYR, EZR) and an angle about the axis; moving: nothing            [METHODS §9]
//! The state has no clamp signal: an axis that stands still is taken as clamped. Limits: seen only where the same
//! experiment reads the axis both at rest and in motion.

use crate::subjects::{axis_of, every_rotary};
use crate::{About, Effect, Emit, Parameter, Scene, Shapes, Subject, Unit};
use nalgebra::Vector3;
use trunnion_machine::{Site, State};
use trunnion_units::{AxisLetter, Twist};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "clamp-shift",
    about: About {
        title: "Shift when the clamp closes",
        source: "METHODS §9",
        equation: "at rest: δ = (EXR, EYR, EZR) and a turn about the axis; in motion: 0",
        validity: "The clamp closes whenever the axis stands still.",
        typical: "1–5 µm",
        explanation: "The axis is pushed aside when its clamp or brake closes.",
        cause: "Clamp or brake that does not pull evenly, drive that lets go before the clamp holds.",
        seen_by: "The same poses at rest and in slow motion, or with the clamp switched off.",
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject) else { return Vec::new() };
    let (slowest, fastest) = scene.speed_range[axis.letter];
    if slowest > 0.0 || fastest <= 0.0 {
        return Vec::new();
    }
    let mut parameters: Vec<_> =
        AxisLetter::LINEAR.map(|letter| Parameter::new(format!("E{letter}{}", axis.letter), Unit::UM)).into();
    parameters.push(Parameter::new("turn", Unit::URAD));
    parameters
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let site = Site::Joint(axis.letter);
    let clamped = f64::from(u8::from(state.velocity[axis.letter] == 0.0));
    for k in 0..3 {
        emit(k, site, Twist::translation(Vector3::ith(k, clamped)));
    }
    emit(3, site, axis.positioning_twist() * clamped);
}
