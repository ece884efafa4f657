//! Pitch error of worm, gear or graduation: cyclic positioning error of a rotary axis.
//!
//! e(q) = a cos Nq + b sin Nq, N cycles a turn                   [S4 table 2: "pitch error in transmission mechanism (e.g. worm gear)"]
//! N: any number that the residual shows; 3…12 (harmonics of the wheel) and, where the machine file gives gear_teeth, the teeth, one more
//! and one fewer, and their double, are tried in any case.
//! Limits: on a grid of poses with step Δ, N is the same as 2π/Δ ± N: only N ≤ π/Δ is tried, and the teeth, which a machine has at any step:
//! they look like a few cycles a turn there, and are then confounded with what else has these. Teeth that look like one or two cycles are
//! rivals of an encoder's error.

use crate::subjects::{axis_of, every_rotary};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
    WaveNumber,
};
use trunnion_core::State;
use trunnion_machine::{Axis, Site};

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "drive-pitch",
    role: Role::Natural,
    about: About {
        title: "Pitch error of worm or gear",
        source: "S4 table 2; docs/design/physics.md §9.5",
        equation: "e = a cos Nq + b sin Nq on the positioning error; N = 3…12, teeth, teeth ± 1, 2 × teeth",
        symbols: "e positioning error, µrad; q angle of the axis; a, b amplitudes, µrad; N cycles a turn (shape number cycles_per_turn)",
        validity: "N known or small; aliases on a coarse grid of poses.",
        typical: "1–10 arcsec",
        explanation: "The axis runs ahead and behind in step with the teeth of its drive.",
        cause: "Pitch error in the transmission (worm gear), or an inaccurate pitch error compensation table.",
        seen_by: "A continuous slow turn, or poses much closer than a tooth.",
        needs: &[Need::Travel],
        helps: &[Need::FinerStep],
    },
    subjects: every_rotary,
    parameters,
    shapes,
    motions,
    example: Example { id: "drive-pitch:C", shape: &[12.0], values: &[("cos", 15.0)], view: View::Turn },
    golden: Golden {
        source: "BIPM SI Brochure, table 8 (1″ = π/648 000 rad)",
        derivation: "10″ at 150 mm from C are 7.272 µm along the tangent; a wheel of 72 teeth repeats them every 5° and reverses them after 2.5°.",
        id: "drive-pitch:C",
        shape: &[72.0],
        values: &[("cos", 48.481368)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, -7.272, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 2.5)], read_um: Some([0.0, 7.272, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 5.0)], read_um: Some([0.0, -7.272, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

/// Cycles a turn below which the encoder or the wheel's run-out is meant.
const FEWEST: f64 = 3.0;

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => {
            ["cos", "sin"].map(|name| Parameter::new(name, Unit::URAD)).into()
        }
        _ => Vec::new(),
    }
}

/// The most teeth that the wheel of a rotary axis has: one a degree.
const MOST_TEETH: f64 = 360.0;

fn shapes(scene: &Scene, subject: Subject) -> Shapes {
    let Some(axis) = axis_of(&scene.machine, subject) else { return Shapes::default() };
    let teeth = axis.facts.gear_teeth;
    let more = |teeth: f64| [teeth - 1.0, teeth, teeth + 1.0, 2.0 * teeth].into_iter().filter(|n| *n > 12.0);
    let known = (3..=12).map(f64::from).chain(teeth.into_iter().flat_map(more));
    let most = scene.most_cycles(axis.letter);
    let (tried, mut aliased): (Vec<f64>, Vec<f64>) =
        known.partition(|n| *n <= (most + 1e-6).max(FEWEST) || Some(*n) == teeth);
    aliased.extend(like_an_encoder(scene, axis).filter(|n| *n > most && !tried.contains(n)));
    Shapes::one("cycles_per_turn", tried, false).waving(WaveNumber::Cycles(axis.letter)).aliasing(aliased)
}

/// Teeth that show once or twice a turn where the axis stands at even steps: an encoder's error does so too.
fn like_an_encoder(scene: &Scene, axis: &Axis) -> impl Iterator<Item = f64> {
    let steps_a_turn = 2.0 * scene.most_cycles(axis.letter);
    let teeth = move |seen: f64| (steps_a_turn - seen).round();
    [1.0, 2.0].into_iter().map(teeth).filter(|n| (FEWEST..=MOST_TEETH).contains(n))
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[n]) = (axis_of(&scene.machine, subject), shape) else { return };
    let (q, site) = (state.position[axis.letter], Site::Joint(axis.letter));
    emit(0, site, axis.positioning_twist() * (n * q).cos());
    emit(1, site, axis.positioning_twist() * (n * q).sin());
}
