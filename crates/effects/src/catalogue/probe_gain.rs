//! Gain error of the probes.
//!
//! m = g · d for each component of the reading, d the deflection           [METHODS §9; S1 §3.2]
//! Limits: nest axes, not the single probe; visible only as far as the probes are deflected, and a gain common to
//! all that never deflects hides.

use crate::{About, Effect, Emit, Parameter, Scene, Shapes, Subject, Unit};
use nalgebra::Vector3;
use trunnion_machine::{Site, State};
use trunnion_units::Twist;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "probe-gain",
    about: About {
        title: "Gain of the probes",
        source: "METHODS §9; S1 §3.2 (nest calibration)",
        equation: "m = g · d for each component",
        validity: "Small deflections; components in nest axes.",
        typical: "1–5 µm/mm",
        explanation: "The probes show a little too much or too little of every displacement.",
        cause: "Calibration of the probes out of date, or the wrong sensitivity in their file; not an error of the machine.",
        seen_by: "Moving the ball by known steps (nest calibration).",
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        deflected(scene).into_iter().map(|k| Parameter::new(COMPONENTS[k], Unit::UM_PER_MM)).collect()
    },
    shapes: |_, _| Shapes::none(),
    motions,
};

/// Names of the components of a reading; a ball bar has the first only.
pub(super) const COMPONENTS: [&str; 3] = ["x", "y", "z"];

/// Components that were deflected, by index.
pub(super) fn deflected(scene: &Scene) -> Vec<usize> {
    (0..3).filter(|&k| scene.deflection_mm[k] > 1e-9).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for (i, k) in deflected(scene).into_iter().enumerate() {
        emit(i, Site::Reading, Twist::translation(Vector3::ith(k, state.deflection_mm[k])));
    }
}
