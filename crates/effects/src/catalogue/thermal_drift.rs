//! Thermal drift of the tool side against the table after a change of heat.
//!
//! u(t) = Σ_i a_i (1 − e^(−(t − t₀)/τ_i)), i = 1, 2 for each of x, y, z in machine axes    [docs/design/physics.md §9.12]
//! Two time constants: drive and spindle warm up in minutes, castings in hours. One time constant is the case where
//! one term is small.
//! Limits: one step of heat at the first point; needs time stamps.

use crate::subjects::whole_tool_side;
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "thermal-drift",
    role: Role::CAUSE,
    about: About {
        title: "Thermal drift of the tool side",
        source: "docs/design/physics.md §9.12; ISO 230-3",
        equation: "u(t) = Σ a_i (1 − e^(−t/τ_i)) for x, y, z, two time constants",
        symbols: "u displacement of the tool side in machine axes, µm; a_i final values, µm; t time since the first point, s; τ_i time constants, s (shape numbers tau1_s, tau2_s)",
        validity: "One change of heat at the beginning; needs time stamps.",
        typical: "5–30 µm, τ 10–120 min",
        explanation: "The machine grows while it warms up or cools down, and the tool wanders.",
        cause: "Warm-up of spindle, drives and structure, or a change of the room or the coolant; with a time constant of a few minutes also a ball, nest or probe that settles after it was mounted.",
        seen_by: "Returning to the first pose, interleaved heights, waiting and repeating.",
        needs: &[Need::TimeStamps],
        helps: &[Need::Return],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes,
    motions,
    example: Example {
        id: "thermal-drift",
        shape: &[600.0, 5400.0],
        values: &[("x.1", 4.0), ("y.2", -6.0), ("z.1", -5.0), ("z.2", 20.0)],
        view: View::Time(7200.0),
    },
    golden: Golden {
        source: "IEC 60050-351 (time constant of a first-order lag element: 63.2 % of the final value)",
        derivation: "10 µm final, τ = 600 s: 6.32 µm 600 s after the first point; the tool side moves, so the reading has its sign.",
        id: "thermal-drift",
        shape: &[600.0, 1e9],
        values: &[("z.1", 10.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { time_s: 100.0, read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { time_s: 700.0, read_um: Some([0.0, 0.0, 6.32]), ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    if !scene.has_time() {
        return Vec::new();
    }
    ["x.1", "y.1", "z.1", "x.2", "y.2", "z.2"].map(|name| Parameter::new(name, Unit::UM)).into()
}

/// Time constants of a warm-up in shares of the duration of the experiment.
pub(super) const TAU_OF_DURATION: [f64; 5] = [0.05, 0.15, 0.4, 1.1, 3.0];

fn shapes(scene: &Scene, _: Subject) -> Shapes {
    let duration_s = scene.duration_s().unwrap_or_default();
    let mut grid = Vec::new();
    for (i, fast) in TAU_OF_DURATION.into_iter().enumerate() {
        for slow in &TAU_OF_DURATION[i + 1..] {
            grid.push(vec![fast * duration_s, slow * duration_s]);
        }
    }
    Shapes { names: vec!["tau1_s".into(), "tau2_s".into()], grid, continuous: true, ..Shapes::default() }
}

/// Share of a warm-up that is done after `elapsed_s`.
pub(super) fn warmed_up(elapsed_s: f64, tau_s: f64) -> f64 {
    if tau_s > 0.0 { 1.0 - (-elapsed_s / tau_s).exp() } else { 0.0 }
}

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(elapsed_s), &[tau1_s, tau2_s]) = (scene.elapsed_s(state), shape) else { return };
    let (site, into_site) = whole_tool_side(&scene.machine, state);
    for (i, tau_s) in [tau1_s, tau2_s].into_iter().enumerate() {
        for k in 0..3 {
            let unit = into_site * Vector3::ith(k, 1.0);
            emit(3 * i + k, site, Twist::translation(unit * warmed_up(elapsed_s, tau_s)));
        }
    }
}
