//! Delays in time between rotary axes, linear axes and probes.
//!
//! probes: e_k = −T_p v_k on every axis: the reading belongs to where the machine was T_p earlier   [docs/design/contracts.md §9; docs/design/physics.md §9.8]
//! rotary: e_k = −T_r v_k on the rotary axes only: they are interpolated, or answer, later than the linear axes   [S4 §2]
//! Linear axes that follow a rotary one keep ball and nest together, Σ J_k v_k = 0: T_p then moves nothing (a reading
//! taken late on a path that reads zero throughout still reads zero), T_r moves J_r v_r. Where only rotary axes move
//! the two are one, and only T_p is carried. Each parameter is carried where the motion of the scene can show it.
//! Limits: on the fly; first order in T; while one rotary axis turns alone T_r is that axis' servo lag.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "sync-delay",
    role: Role::CAUSE,
    about: About {
        title: "Delay between rotary axes, linear axes and probes",
        source: "docs/design/physics.md §9.8; S4 §2 (synchronisation error)",
        equation: "probes: e = −T_p v on every axis; rotary: e = −T_r v on the rotary axes only",
        symbols: "T_p time by which the probes are read late against all axis positions, ms; T_r time by which the rotary axes come later than the linear axes, ms; v velocity of each axis",
        validity: "Read on the fly; one delay for the whole experiment. T_p shows only where the motion changes the distance of ball and nest (never while linear axes follow a rotary one exactly); T_r only where linear and rotary axes move together.",
        typical: "0.1–10 ms: 21 µm per ms at 360°/min on R 200 mm",
        explanation: "Rotary axes, linear axes and probes do not belong to the same instant.",
        cause: "T_p: time on the way through control, network and probe electronics, not an error of the machine. T_r: interpolator, servo gains or feed-forward of rotary and linear axes not matched.",
        seen_by: "Both directions of travel at two feeds: the error flips with direction and doubles with the feed.",
        needs: &[Need::OnTheFly, Need::DelayShows],
        helps: &[Need::BothDirections, Need::TwoFeeds],
    },
    subjects: |_| vec![Subject::Whole],
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example { id: "sync-delay", shape: &[], values: &[("rotary", 0.2)], view: View::Turn },
    golden: Golden {
        source: "Circumference 2πR",
        derivation: "A table at 1 turn a minute moves 2π · 200 mm/60 s = 20.94 mm/s at R = 200 mm: 1 ms late it is 20.94 µm behind the tool that follows it.",
        id: "sync-delay",
        shape: &[],
        values: &[("rotary", 1.0)],
        balls_mm: &[[200.0, 0.0, 0.0]],
        moments: &[
            Moment {
                position: &[("X", 200.0)],
                velocity: &[("C", 6.0), ("Y", 20.943951)],
                read_um: Some([0.0, 20.94, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("X", 200.0)],
                velocity: &[("C", -6.0), ("Y", -20.943951)],
                read_um: Some([0.0, -20.94, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.005,
    },
};

#[derive(Clone, Copy)]
enum Delay {
    /// Of the probes against every axis.
    Probes,
    /// Of the rotary axes against the linear axes.
    Rotary,
}

/// The delays that the motion of the scene shows.
fn delays(scene: &Scene) -> Vec<Delay> {
    let mut delays = Vec::new();
    if scene.on_the_fly && scene.path.changes_reading {
        delays.push(Delay::Probes);
    }
    if scene.on_the_fly && scene.path.linear_with_rotary {
        delays.push(Delay::Rotary);
    }
    delays
}

fn parameters(scene: &Scene, _: Subject) -> Vec<Parameter> {
    let name = |delay| match delay {
        Delay::Probes => "probes",
        Delay::Rotary => "rotary",
    };
    delays(scene).into_iter().map(|delay| Parameter::new(name(delay), Unit::MS)).collect()
}

fn motions(scene: &Scene, _: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    for (i, delay) in delays(scene).into_iter().enumerate() {
        for axis in scene.machine.axes() {
            if matches!(delay, Delay::Probes) || axis.is_rotary() {
                emit(i, Site::Joint(axis.letter), axis.positioning_twist() * -state.velocity[axis.letter]);
            }
        }
    }
}
