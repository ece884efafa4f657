//! Tilt error motion (coning, angular motion): the axis line leans while it turns.
//!
//! ω(q) = R(+nq) f + R(−nq) b,  f and b across the axis, n = 1…3          [ISO 230-7 §3; S1 §5.3 (coning); S4 §4.2.2, table 2]
//! n = 1 forward turns with the table: to the ball it is part of the ball setting and gives no motion here.
//! Limits: repeats every turn.

use crate::phasors;
use crate::subjects::{every_rotary, rotary_name};
use crate::{About, Effect, Example, Golden, Moment, Need, Role, Shapes, Unit, View};
use trunnion_core::Twist;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "tilt-error-motion",
    role: Role::Natural,
    about: About {
        title: "Tilt error motion (coning)",
        source: "ISO 230-7; S1 §5.3; S4 §4.2.2 and table 2 (angular motion of the rotation centre line)",
        equation: "ω = R(+nq) f + R(−nq) b across the axis, n = 1…3; n = 1 forward is part of the ball setting",
        symbols: "ω tilt of the axis line, µrad; q angle of the axis; f, b phasors that turn forward and backward, µrad; n lobes a turn (shape number lobes)",
        validity: "Repeats every turn.",
        typical: "2–230 µrad",
        explanation: "The axis line wobbles like a top while it turns.",
        cause: "Angular motion of the centre line: ring profile of the bearing, two bearings out of line, rollers of unequal size.",
        seen_by: "Two heights of the ball: the wander grows with height.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights],
    },
    subjects: every_rotary,
    parameters: |scene, subject| phasors::parameters(scene, subject, rotary_name, Unit::URAD),
    shapes: |_, _| Shapes::one("lobes", (1..=3).map(f64::from), false),
    motions: |scene, subject, shape, state, emit| {
        phasors::motions(scene, subject, shape, state, Twist::rotation, emit);
    },
    example: Example {
        id: "tilt-error-motion:C",
        shape: &[2.0],
        values: &[("EAC.backward", 20.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "S1 §5.3 (coning of B: EAB up to 0.013°)",
        derivation: "0.013° = 226.9 µrad at a ball 100 mm above the pivot are 22.69 µm: ω × r = x̂ × ẑ = −ŷ of the table.",
        id: "tilt-error-motion:B",
        shape: &[1.0],
        values: &[("EAB.backward", 226.893)],
        balls_mm: &[[0.0, 0.0, 100.0]],
        moments: &[
            Moment { read_um: Some([0.0, 22.69, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("B", 30.0)], ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};
