//! Gain error of the probes.
//!
//! m = g · d for each component of the reading, d the deflection           [docs/design/physics.md §9.15; S1 §3.2]
//! Limits: nest axes, not the single probe; visible only as far as the probes are deflected, and a gain common to
//! all that never deflects hides.

use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "probe-gain",
    role: Role::CAUSE,
    about: About {
        title: "Gain of the probes",
        source: "docs/design/physics.md §9.15; S1 §3.2 (nest calibration)",
        equation: "m = g · d for each component",
        symbols: "m error of the reading; g gain error, µm/mm; d deflection",
        validity: "Small deflections; components in nest axes.",
        typical: "1–5 µm/mm",
        explanation: "The probes show a little too much or too little of every displacement.",
        cause: "Calibration of the probes out of date, or the wrong sensitivity in their file; not an error of the machine.",
        seen_by: "Moving the ball by known steps (nest calibration).",
        needs: &[Need::Deflection],
        helps: &[Need::KnownSteps],
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        deflected(scene)
            .into_iter()
            .map(|k| Parameter::new(COMPONENTS[k], Unit::UM_PER_MM).at_most(GAIN))
            .collect()
    },
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example { id: "probe-gain", shape: &[], values: &[("x", 3.0)], view: View::Deflection },
    golden: Golden {
        source: "Abramowitz & Stegun table 4.10 (cos 1° = 0.999848)",
        derivation: "A probe 1° off its direction shows cos 1° of a displacement: 0.1523 µm too little for each mm, 0.305 µm for 2 mm.",
        id: "probe-gain",
        shape: &[],
        values: &[("x", -0.1523)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { deflection_mm: [2.0, 0.0, 0.0], read_um: Some([-0.305, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [-2.0, 0.0, 0.0], read_um: Some([0.305, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

/// Half of the deflection: no probe leaves its calibration so far. −1000 µm/mm undoes what the recorded positions ask for.
const GAIN: Limit = Limit {
    largest: 500.0,
    beyond: "the readings do not follow the recorded positions to the last micrometre: those may be rounded, or asked for \
             instead of read",
    resembles: false,
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
