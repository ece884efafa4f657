//! The nest is turned against the axes it should read in.
//!
//! m = −ω × d, d the deflection in nest axes, ω the turn of the nest        [docs/design/physics.md §3, §9.15: direction vectors of the probes; S1 §3.2]
//! Limits: three-component instruments; visible only as far as the probes are deflected.

use crate::{About, Effect, Emit, Example, Need, Parameter, Scene, Shapes, Subject, Unit, View};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "nest-rotation",
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
};

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let three_components = scene.setups.iter().any(|setup| setup.components.len() == 3);
    if !three_components || scene.deflection_mm.amax() <= 1e-9 {
        return Vec::new();
    }
    ["a", "b", "c"].map(|name| Parameter::new(name, Unit::URAD)).into()
}

fn motions(_: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for k in 0..3 {
        let turned = -Vector3::ith(k, 1.0).cross(&state.deflection_mm);
        emit(k, Site::Reading, Twist::translation(turned));
    }
}
