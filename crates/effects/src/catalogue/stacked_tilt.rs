//! Tilt error motion of a rotary axis that changes with the tilt of the axis it is stacked on.
//!
//! ω(B, C) = load(B) · [R(+nC) f + R(−nC) b],  load = sin B (radial) or 1 − cos B (axial), n = 1, 2      [S4 table 2: EAC(C, B), EBC(C, B)]
//! The part that does not change with C is B's own tilt error motion. Limits: repeats every turn of C.

use crate::subjects::{across, axis_of, rotary_below, rotary_name};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::UnitQuaternion;
use trunnion_core::{State, Twist};
use trunnion_machine::{Machine, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "stacked-tilt",
    role: Role::CAUSE,
    about: About {
        title: "Tilt error motion that depends on the axis below",
        source: "S4 table 2 (αC(C, B), βC(C, B)); S1 §5.3",
        equation: "ω = load(B)·[R(+nC) f + R(−nC) b], load 0: sin B, 1: 1 − cos B; n = 1, 2",
        symbols: "ω tilt of the upper axis C, µrad; B tilt of the lower one; f, b phasors, µrad; n lobes a turn (shape number lobes); load how gravity comes in (shape number load)",
        validity: "Repeats every turn of the upper axis.",
        typical: "2–50 µrad",
        explanation: "The upper axis wobbles more, or otherwise, when the lower axis is tilted.",
        cause: "Bearing of the upper axis that gives way to the changing direction of the weight; out-of-round rings under load.",
        seen_by: "Whole turns of the upper axis at several tilts, two heights.",
        needs: &[Need::Travel, Need::SeveralTilts],
        helps: &[Need::TwoHeights],
    },
    subjects: |machine: &Machine| {
        machine
            .rotary()
            .into_iter()
            .filter(|axis| rotary_below(machine, axis.letter).is_some())
            .map(|axis| Subject::Axis(axis.letter))
            .collect()
    },
    parameters,
    shapes: |_, _| Shapes {
        names: vec!["lobes".into(), "load".into()],
        grid: [[1.0, 0.0], [1.0, 1.0], [2.0, 0.0], [2.0, 1.0]].map(Vec::from).into(),
        ..Shapes::default()
    },
    motions,
    example: Example {
        id: "stacked-tilt:C",
        shape: &[1.0, 0.0],
        values: &[("EBC.forward", 20.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "Meriam & Kraige, Statics, ch. 2 (component of a weight along a slope: W sin B)",
        derivation: "Half of the weight acts across C at B = 30°: half of 20 µrad at a ball 100 mm up is 1 µm; a forward phasor turns with the table.",
        id: "stacked-tilt:C",
        shape: &[1.0, 0.0],
        values: &[("EBC.forward", 20.0)],
        balls_mm: &[[0.0, 0.0, 100.0]],
        moments: &[
            Moment { read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("B", 30.0)], read_um: Some([-1.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment {
                position: &[("B", 30.0), ("C", 90.0)],
                read_um: Some([-1.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment { position: &[("B", -30.0)], read_um: Some([1.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.moves(axis.letter)) else {
        return Vec::new();
    };
    if !rotary_below(&scene.machine, axis.letter).is_some_and(|below| scene.moves(below.letter)) {
        return Vec::new();
    }
    let [first, second, _] = across(&axis.direction).index.map(rotary_name);
    let name = |turn: &str, direction: &str| {
        Parameter::new(format!("E{direction}{}.{turn}", axis.letter), Unit::URAD)
    };
    vec![name("forward", first), name("forward", second), name("backward", first), name("backward", second)]
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[n, load]) = (axis_of(&scene.machine, subject), shape) else { return };
    let Some(below) = rotary_below(&scene.machine, axis.letter) else { return };
    let tilt = below.sense * state.position[below.letter];
    let load = if load < 0.5 { tilt.sin() } else { 1.0 - tilt.cos() };
    let site = Site::Joint(axis.letter);
    let across = across(&axis.direction);
    let angle = axis.sense * state.position[axis.letter];
    let forward = UnitQuaternion::from_axis_angle(&axis.direction, n * angle);
    for (k, e) in [across.first, across.second].into_iter().enumerate() {
        emit(k, site, Twist::rotation(forward * e * load));
        emit(2 + k, site, Twist::rotation(forward.inverse() * e * load));
    }
}
