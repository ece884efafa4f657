//! Form of an uncalibrated artefact: the balls of a plate are not where its drawing says.
//!
//! δ = (x, y, z) of each target, artefact axes; the same in every placement     [S2 §3.3: self-calibration]
//! Limits: a rigid artefact. Its size, place and direction as a whole cannot be distinguished from the machine's without turned
//! placements or a known length: fix the targets that define them.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, SceneArtefact, SceneSetup,
    Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "artefact-form",
    role: Role::Setting,
    about: About {
        title: "Form of an uncalibrated artefact",
        source: "S2 §3.3 (self-calibration)",
        equation: "δ = (x, y, z) of each target in artefact axes, the same in every placement",
        symbols: "δ actual minus nominal place of a ball or face, µm",
        validity: "Rigid artefact; constant over the runs.",
        typical: "5–50 µm for an uncalibrated plate",
        explanation: "The balls of the plate are not exactly where its drawing says.",
        cause: "The artefact was never calibrated, or it has changed since; not an error of the machine.",
        seen_by: "Measuring the artefact in several placements, turned against each other.",
        needs: &[Need::Targets],
        helps: &[Need::Travel],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "artefact-form",
        shape: &[],
        values: &[("plate.1.x", 10.0), ("plate.1.z", 5.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "ISO 3650 (steel: 11.5 µm/(m·K))",
        derivation: "A steel plate 2 K warmer than its calibration: the ball 400 mm from the fixed one is 9.2 µm further out, the fixed one stays.",
        id: "artefact-form",
        shape: &[],
        values: &[("plate.2.x", 9.2)],
        balls_mm: &[[0.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { target: 1, read_um: Some([-9.2, 0.0, 0.0]), ..Moment::AT_REST },
            Moment {
                position: &[("C", 90.0)],
                target: 1,
                read_um: Some([-9.2, 0.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.05,
    },
};

/// Artefacts with more than one target, each once.
fn artefacts(scene: &Scene) -> Vec<&SceneArtefact> {
    let mut all: Vec<&SceneArtefact> = Vec::new();
    for artefact in scene.setups.iter().filter_map(several) {
        if !all.iter().any(|other| other.name == artefact.name) {
            all.push(artefact);
        }
    }
    all
}

fn several(setup: &SceneSetup) -> Option<&SceneArtefact> {
    setup.artefact.as_ref().filter(|artefact| artefact.targets.len() > 1)
}

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let of_target = |artefact: &SceneArtefact, target: &String| {
        ["x", "y", "z"].map(|k| Parameter::new(format!("{}.{target}.{k}", artefact.name), Unit::UM))
    };
    let of_artefact = |artefact: &SceneArtefact| {
        artefact.targets.iter().flat_map(|target| of_target(artefact, target)).collect::<Vec<_>>()
    };
    artefacts(scene).into_iter().flat_map(of_artefact).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(own) = scene.setups.get(state.setup).and_then(several) else { return };
    let before = artefacts(scene).into_iter().take_while(|other| other.name != own.name);
    let first: usize = before.map(|artefact| 3 * artefact.targets.len()).sum();
    for k in 0..3 {
        let in_table = own.table_from_artefact * Vector3::ith(k, 1.0);
        emit(first + 3 * state.target + k, Site::TableBall, Twist::translation(in_table));
    }
}
