//! Cross-talk between the probes: each holds a share of what the others read.
//!
//! m_i = Σ k_ij d_j, j ≠ i, d the deflection in nest axes                   [docs/design/physics.md §9.15; S1 §3.2: direction vectors]
//! Limits: nest axes, not the single probe; visible only as far as the probes are deflected. k_ij = −k_ji is a turn of the nest
//! (`nest-rotation`); what a probe that leans over shows too little of its own axis is its gain.

use super::probe_gain::{COMPONENTS, deflected};
use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "probe-crosstalk",
    role: Role::CAUSE,
    about: About {
        title: "Cross-talk between the probes",
        source: "docs/design/physics.md §9.15; S1 §3.2 (direction vectors)",
        equation: "m_i = Σ k_ij d_j, j ≠ i",
        symbols: "m error of the reading; k_ij share of the deflection d_j in reading i, µm/mm (10 µm/mm are 1 %)",
        validity: "Components in nest axes; same in all setups.",
        typical: "1–300 µm/mm",
        explanation: "A probe also shows a share of what its neighbour measures.",
        cause: "Cables or amplifiers that couple, eddy-current probes too close to each other, or a probe that leans towards another one; not an error of the machine.",
        seen_by: "Moving the ball by known steps along X, Y, Z (nest calibration): more than one probe moves.",
        needs: &[Need::Deflection, Need::ThreeComponents],
        helps: &[Need::KnownSteps],
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        let name = |(i, j): (usize, usize)| format!("{}-of-{}", COMPONENTS[i], COMPONENTS[j]);
        pairs(scene)
            .into_iter()
            .map(|pair| Parameter::new(name(pair), Unit::UM_PER_MM).at_most(SHARE))
            .collect()
    },
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "probe-crosstalk",
        shape: &[],
        values: &[("y-of-x", 100.0), ("z-of-x", 50.0)],
        view: View::Deflection,
    },
    golden: Golden {
        source: "Abramowitz & Stegun table 4.10 (sin 6° = 0.1045285)",
        derivation: "A probe y that leans 6° towards x shows 0.1045285 of a displacement in x: 52.264 µm of 0.5 mm, and nothing of one in z.",
        id: "probe-crosstalk",
        shape: &[],
        values: &[("y-of-x", 104.5285)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { deflection_mm: [0.5, 0.0, 0.0], read_um: Some([0.0, 52.264, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [0.0, 0.5, 0.0], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [-0.2, 0.0, 0.3], read_um: Some([0.0, -20.906, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

/// Half of the neighbour's reading: inputs that hold more are exchanged, which the plausibility of the runs tries.
const SHARE: Limit =
    Limit { largest: 500.0, beyond: "inputs that hold so much of each other are exchanged", resembles: true };

/// (i, j): reading i holds a share of the deflection j, which is there.
fn pairs(scene: &Scene) -> Vec<(usize, usize)> {
    let three_components = scene.setups.iter().any(|setup| setup.components.len() == 3);
    let sources = if three_components { deflected(scene) } else { Vec::new() };
    sources.into_iter().flat_map(|j| (0..3).filter(move |i| *i != j).map(move |i| (i, j))).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for (k, (i, j)) in pairs(scene).into_iter().enumerate() {
        emit(k, Site::Reading, Twist::translation(Vector3::ith(i, state.deflection_mm[j])));
    }
}
