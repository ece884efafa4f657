//! Squareness between two linear axes of a machine with rotary axes.
//!
//! EC0Y (Y to X), EB0Z (Z to X), EA0Z (Z to Y): δ = angle × travel of the later axis        [S2 tables 2–5; S4 table 1]
//! A machine without rotary axes carries them in `location-errors` already. Limits: constant over the run.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::axis::iso::{X, Y, Z};
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::{Machine, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "squareness",
    role: Role::Location,
    about: About {
        title: "Squareness of two linear axes",
        source: "S2 tables 2–5; S4 table 1",
        equation: "δ = E × travel: EC0Y (YX), EB0Z (ZX), EA0Z (ZY)",
        symbols: "δ displacement; E angle, µrad; travel of the later axis",
        validity: "Constant over the run.",
        typical: "10–50 µm/m",
        explanation: "Two linear axes do not meet at a right angle.",
        cause: "Alignment of the guideways, or a machine standing unevenly on its feet.",
        seen_by: "A circle in the plane of the two axes (45° oval, the same in both directions); rotary cycles at two heights.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights],
    },
    subjects,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "squareness:YX",
        shape: &[],
        values: &[("EC0Y", 40.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "S2 eq. 1 (ex = −EC0Y · y)",
        derivation: "50 µm/m over 200 mm of Y: 10 µm towards −X.",
        id: "squareness:YX",
        shape: &[],
        values: &[("EC0Y", 50.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { position: &[("Y", 200.0)], read_um: Some([-10.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("Y", -200.0)], read_um: Some([10.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

fn subjects(machine: &Machine) -> Vec<Subject> {
    if machine.rotary().is_empty() {
        return Vec::new();
    }
    [(Y, X), (Z, X), (Z, Y)]
        .into_iter()
        .filter(|&(a, b)| machine.axis(a).is_some() && machine.axis(b).is_some())
        .filter(|&(a, b)| !machine.is_leg(a) && !machine.is_leg(b))
        .map(|(a, b)| Subject::Pair(a, b))
        .collect()
}

/// The coordinate direction about which the pair leans, by index.
fn about(first: Joint, second: Joint) -> usize {
    3 - first.index() - second.index()
}

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match subject {
        Subject::Pair(first, second) if scene.moves(first) => {
            let rotary = Joint::ROTARY[about(first, second)];
            vec![Parameter::new(format!("E{rotary}0{first}"), Unit::URAD)]
        }
        Subject::Pair(..) | Subject::Whole | Subject::Axis(_) => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Subject::Pair(first, second) = subject else { return };
    let Some(axis) = scene.machine.axis(first) else { return };
    let travel = axis.positioning_twist().translation_mm * state.position[first];
    let leaning = Vector3::ith(about(first, second), 1.0).cross(&travel);
    emit(0, Site::Joint(first), Twist::translation(leaning));
}
