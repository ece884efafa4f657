//! Setting of the table-side ball or nest: its actual minus nominal place, table axes, one for each setup.
//!
//! reading change = −R_tableᵀ-projected offset of the table side [S0 §3, S1 eq. 14: "or carry a free offset per set-up"]. The spindle
//! side is taken as centred by spindle indexing (S1 §3.2). A ball bar has a free length as well.
//! Limits: constant within a setup.

use crate::{About, Effect, Emit, Example, Need, Parameter, Scene, Shapes, Subject, Unit, View};
use nalgebra::Vector3;
use trunnion_machine::{Site, State};
use trunnion_units::Twist;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "ball-setting",
    about: About {
        title: "Setting of ball and nest",
        source: "S0 §3; S1 eq. 14",
        equation: "s = (x, y, z) of the table-side ball or nest in table axes, one for each setup; length of a ball bar",
        symbols: "s actual minus nominal place, µm; x, y, z in table axes; length of a ball bar, µm",
        validity: "Constant within a setup; spindle-side ball centred by spindle indexing (S1 §3.2).",
        typical: "10–200 µm",
        explanation: "The ball does not sit exactly where the setup file says.",
        cause: "Clamping the ball or the nest by hand.",
        seen_by: "Always.",
        needs: &[],
        helps: &[Need::Travel],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "ball-setting",
        shape: &[],
        values: &[("ball-setting.low.x", 50.0), ("ball-setting.low.z", 30.0)],
        view: View::Poses,
    },
};

fn is_bar(components: &[&str]) -> bool {
    components.len() == 1
}

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for setup in &scene.setups {
        let names: &[&str] =
            if is_bar(setup.components) { &["x", "y", "z", "length"] } else { &["x", "y", "z"] };
        parameters.extend(
            names.iter().map(|name| Parameter::new(format!("ball-setting.{}.{name}", setup.name), Unit::UM)),
        );
    }
    parameters
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let width = |i: usize| if is_bar(scene.setups[i].components) { 4 } else { 3 };
    let first: usize = (0..state.setup).map(width).sum();
    for k in 0..3 {
        emit(first + k, Site::TableBall, Twist::translation(Vector3::ith(k, 1.0)));
    }
    if width(state.setup) == 4 {
        emit(first + 3, Site::Reading, Twist::translation(-Vector3::x()));
    }
}
