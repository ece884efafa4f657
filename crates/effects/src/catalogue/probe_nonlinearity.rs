//! Non-linearity of the probes.
//!
//! m = q · d² for each component of the reading, d the deflection       [docs/design/physics.md §9.15: m = g·d + q·d²]
//! Limits: nest axes, not the single probe; second order only.

use super::probe_gain::{COMPONENTS, deflected};
use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "probe-nonlinearity",
    role: Role::CAUSE,
    about: About {
        title: "Non-linearity of the probes",
        source: "docs/design/physics.md §9.15",
        equation: "m = q · d² for each component",
        symbols: "m error of the reading; q curvature, µm/mm²; d deflection, mm",
        validity: "Second order; components in nest axes.",
        typical: "0.1–1 µm over the range",
        explanation: "The probes show large displacements differently from small ones.",
        cause: "Probes used at the end of their range, or near a metal part (eddy current); not an error of the machine.",
        seen_by: "Known steps of different size (nest calibration).",
        needs: &[Need::Deflection],
        helps: &[Need::KnownSteps],
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        let curvature = |k: usize| Parameter::new(COMPONENTS[k], Unit::UM_PER_MM2).at_most(CURVATURE);
        deflected(scene).into_iter().map(curvature).collect()
    },
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example { id: "probe-nonlinearity", shape: &[], values: &[("x", 4.0)], view: View::Deflection },
    golden: Golden {
        source: "Vishay Tech Note TN-507, eq. 507.1 (quarter bridge: output × 2/(2 + F ε))",
        derivation: "F = 2 and 1000 µε per mm: 0.1 % = 1 µm low at 1 mm, 0.05 % of 0.5 mm = 0.25 µm low there, and low again on the other side.",
        id: "probe-nonlinearity",
        shape: &[],
        values: &[("x", -1.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { deflection_mm: [1.0, 0.0, 0.0], read_um: Some([-1.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [0.5, 0.0, 0.0], read_um: Some([-0.25, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [-1.0, 0.0, 0.0], read_um: Some([-1.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};

/// Half of a deflection of 0.1 mm, the shortest range of a probe: as of a gain. A ball bar a few µm off its centre would need more to stand for
/// a scale error. A judgement, tuned on no data.
const CURVATURE: Limit = Limit {
    largest: 5000.0,
    beyond: "no probe reads a tenth of a millimetre wrong by half of it",
    resembles: true,
};

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for (i, k) in deflected(scene).into_iter().enumerate() {
        emit(i, Site::Reading, Twist::translation(Vector3::ith(k, state.deflection_mm[k].powi(2))));
    }
}
