//! Reversal spike: the axis sticks when its direction turns and catches up with travel.
//!
//! e = −h · direction · e^(−s/s₀) on the positioning error, s travel since the reversal, s₀ its decay     [docs/design/physics.md §5, §9.7; ISO 230-4 quadrant glitch]
//! Limits: read on the fly; feed and friction constant.

use crate::subjects::{axis_of, every_axis};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "reversal-spike",
    role: Role::CAUSE,
    about: About {
        title: "Spike after a reversal",
        source: "docs/design/physics.md §5, §9.7; ISO 230-4",
        equation: "e = −h · direction · e^(−s/s₀), s travel since the reversal",
        symbols: "e positioning error, µm or µrad; h height of the spike, µm or µrad; s travel since the reversal; s₀ travel after which it has fallen to 37 %, mm or rad (shape number decay)",
        validity: "Read on the fly; constant feed and friction.",
        typical: "5–20 µm",
        explanation: "The axis sticks for a moment when it turns round, then catches up.",
        cause: "Friction at standstill (stick-slip) that the servo compensates too late: seals, guideways, missing friction compensation.",
        seen_by: "On-the-fly circles through the reversal, at two feeds.",
        needs: &[Need::OnTheFly, Need::BothDirections],
        helps: &[Need::TwoFeeds],
    },
    subjects: every_axis,
    parameters,
    shapes,
    motions,
    example: Example {
        id: "reversal-spike:X",
        shape: &[3.0],
        values: &[("h", 8.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "Abramowitz & Stegun table 4.4 (e⁻¹ = 0.36788)",
        derivation: "A spike of 8 µm that decays over 3 mm holds X back by 8 µm at the reversal. 3 mm later it is 2.943 µm.",
        id: "reversal-spike:X",
        shape: &[3.0],
        values: &[("h", 8.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment {
                direction: &[("X", 1.0)],
                velocity: &[("X", 10.0)],
                read_um: Some([-8.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("X", 3.0)],
                direction: &[("X", 1.0)],
                velocity: &[("X", 10.0)],
                since_reversal: &[("X", 3.0)],
                read_um: Some([-2.943, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment {
                position: &[("X", 3.0)],
                direction: &[("X", -1.0)],
                velocity: &[("X", -10.0)],
                read_um: Some([8.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.0005,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.read_in_motion(axis.letter) && scene.both_directions(axis.letter) => {
            vec![Parameter::new("h", if axis.is_rotary() { Unit::URAD } else { Unit::UM })]
        }
        _ => Vec::new(),
    }
}

fn shapes(scene: &Scene, subject: Subject) -> Shapes {
    match axis_of(&scene.machine, subject) {
        Some(axis) if axis.is_rotary() => {
            Shapes::one("decay_rad", [0.1f64, 0.3, 1.0, 3.0, 10.0].map(f64::to_radians), true)
        }
        _ => Shapes::one("decay_mm", [0.03, 0.1, 0.3, 1.0, 3.0], true),
    }
}

fn motions(scene: &Scene, subject: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(axis), &[decay]) = (axis_of(&scene.machine, subject), shape) else { return };
    let k = axis.letter;
    let stuck = -state.direction[k] * (-state.since_reversal[k].abs() / decay).exp();
    emit(0, Site::Joint(k), axis.positioning_twist() * stuck);
}
