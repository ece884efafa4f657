//! Setting of the table-side ball, nest, station or artefact: its actual minus nominal place, table axes, one for each setup, and
//! what else a mounting leaves unknown (length of a bar, dead path, turn of an artefact, tilt of a mirror): the instrument says.
//!
//! reading change = −R_tableᵀ-projected offset of the table side [S0 §3, S1 eq. 14: "or carry a free offset per set-up"]. The spindle
//! side is taken as centred by spindle indexing (S1 §3.2). A ball bar has a free length as well.
//! Limits: constant within a setup.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, SceneSetting, SceneSetup,
    Shapes, Subject, View,
};
use trunnion_core::State;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "ball-setting",
    role: Role::Setting,
    about: About {
        title: "Setting of ball and nest",
        source: "S0 §3; S1 eq. 14",
        equation: "s = (x, y, z) of the table-side ball, nest, station or artefact in table axes, one for each setup; and what else the instrument leaves unknown",
        symbols: "s actual minus nominal place, µm; length of a bar, dead path, zero, radius, µm; a, b, c turn of an artefact, tilts of beam and mirror, µrad",
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
    golden: Golden {
        source: "ISO 230-7 (setting error of the artefact: once a turn, its amplitude the eccentricity)",
        derivation: "A ball 50 µm off along the table's x turns with the table: −50 µm in table axes at every angle of C.",
        id: "ball-setting",
        shape: &[],
        values: &[("ball-setting.low.x", 50.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([-50.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 90.0)], read_um: Some([-50.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 180.0)], read_um: Some([-50.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.5,
    },
};

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let of_setup = |setup: &SceneSetup| -> Vec<Parameter> {
        let named = |s: &SceneSetting| {
            let name = format!("ball-setting.{}.{}", setup.name, s.name);
            Parameter::new(name, s.unit).known_within(s.u_beforehand)
        };
        setup.settings.iter().map(named).collect()
    };
    scene.setups.iter().flat_map(of_setup).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let first: usize = scene.setups[..state.setup].iter().map(|setup| setup.settings.len()).sum();
    for (k, setting) in scene.setups[state.setup].settings.iter().enumerate() {
        emit(first + k, setting.site, setting.twist);
    }
}
