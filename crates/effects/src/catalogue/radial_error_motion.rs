//! Radial error motion: the axis line wanders across while it turns.
//!
//! δ(q) = R(+nq) f + R(−nq) b,  f and b across the axis, n = 1…4         [ISO 230-7 §3; S0 §3; docs/design/physics.md §9.3]
//! Every Fourier term of EXC and EYC is a sum of one phasor that turns n times forward and one that turns n times backward.
//! n = 1 forward turns with the table: it *is* the ball setting (or the place of the next axis) and gives no motion here.
//! Limits: repeats every turn.

use super::axial_error_motion::RUN_OUT;
use crate::phasors;
use crate::subjects::{every_rotary, linear_name};
use crate::{About, Effect, Example, Golden, Moment, Need, Role, Shapes, Unit, View};
use trunnion_core::Twist;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "radial-error-motion",
    role: Role::Natural,
    about: About {
        title: "Radial error motion",
        source: "ISO 230-7; S0 §3; S4 §4.2.2 and table 2",
        equation: "δ = R(+nq) f + R(−nq) b across the axis, n = 1…4; n = 1 forward is the ball setting",
        symbols: "δ displacement of the axis line, µm; q angle of the axis; f, b phasors that turn forward and backward, µm; n lobes a turn (shape number lobes)",
        validity: "Repeats every turn.",
        typical: "1 µm",
        explanation: "The axis line runs out sideways while it turns.",
        cause: "Bearing run-out: out-of-round rings or rollers of unequal size.",
        seen_by: "Turning the axis with the ball near its line, at two heights; a second ball radius separates n = 1 from a scale error.",
        needs: &[Need::Travel],
        helps: &[Need::TwoHeights, Need::TwoRadii],
    },
    subjects: every_rotary,
    parameters: |scene, subject| {
        let phasors = phasors::parameters(scene, subject, linear_name, Unit::UM);
        phasors.into_iter().map(|phasor| phasor.at_most(RUN_OUT)).collect()
    },
    shapes: |_, _| Shapes::one("lobes", (1..=4).map(f64::from), false),
    motions: |scene, subject, shape, state, emit| {
        phasors::motions(scene, subject, shape, state, Twist::translation, emit);
    },
    example: Example {
        id: "radial-error-motion:C",
        shape: &[2.0],
        values: &[("EXC.forward", 1.0), ("EXC.backward", 1.0)],
        view: View::Turn,
    },
    golden: Golden {
        source: "ISO 230-7 (radial error motion in a fixed direction, two lobes)",
        derivation: "EXC = 1 µm · cos 2C is half a phasor forward and half backward: +1, 0, −1 µm along machine X at 0, 45, 90°.",
        id: "radial-error-motion:C",
        shape: &[2.0],
        values: &[("EXC.forward", 0.5), ("EXC.backward", 0.5)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([-1.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 45.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 90.0)], read_um: Some([0.0, -1.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 1e-06,
    },
};
