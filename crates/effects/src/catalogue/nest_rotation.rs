//! The nest is turned against the axes it should read in.
//!
//! m = −ω × d, d the deflection in nest axes, ω the turn of the nest        [docs/design/physics.md §3, §9.15: direction vectors of the probes; S1 §3.2]
//! Limits: three-component instruments; visible only as far as the probes are deflected.

use crate::{
    About, Effect, Emit, Example, Golden, Limit, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit,
    View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "nest-rotation",
    role: Role::CAUSE,
    about: About {
        title: "Nest turned against the axes",
        source: "docs/design/physics.md §9.15; S1 §3.2 (direction vectors)",
        equation: "m = −ω × d",
        symbols: "m error of the reading; ω turn of the nest about its x, y, z, µrad; d deflection",
        validity: "Small turn; same in all setups.",
        typical: "1–5 mrad by hand",
        explanation: "The nest stands a little askew, so that a move in X also shows in Y.",
        cause: "Nest mounted by hand without alignment; not an error of the machine.",
        seen_by: "Moving the ball by known steps along X, Y, Z (nest calibration).",
        needs: &[Need::Deflection, Need::ThreeComponents],
        helps: &[Need::KnownSteps],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "nest-rotation",
        shape: &[],
        values: &[("c", 2000.0), ("b", 1000.0)],
        view: View::Deflection,
    },
    golden: Golden {
        source: "Goldstein, Classical Mechanics, ch. 4 (coordinates in axes turned by φ: y′ = y cos φ − x sin φ)",
        derivation: "A nest turned by +0.1° about z (1745.3 µrad, sin 0.1° = 0.0017453) reads 0.5 mm in x as −0.873 µm in y.",
        id: "nest-rotation",
        shape: &[],
        values: &[("c", 1745.329)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { deflection_mm: [0.5, 0.0, 0.0], read_um: Some([0.0, -0.873, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [0.0, 0.5, 0.0], read_um: Some([0.873, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { deflection_mm: [0.0, 0.0, 0.5], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

/// 10°, from which on a nest is mounted the wrong way, which the plausibility of the runs tries; the equation is of small turns.
const TURN: Limit =
    Limit { largest: 174_533.0, beyond: "a nest that far askew is seen by eye", resembles: true };

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let three_components = scene.setups.iter().any(|setup| setup.components.len() == 3);
    if !three_components || scene.deflection_mm.amax() <= 1e-9 {
        return Vec::new();
    }
    ["a", "b", "c"].map(|name| Parameter::new(name, Unit::URAD).at_most(TURN)).into()
}

fn motions(_: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for k in 0..3 {
        let turned = -Vector3::ith(k, 1.0).cross(&state.deflection_mm);
        emit(k, Site::Reading, Twist::translation(turned));
    }
}
