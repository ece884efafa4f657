//! Slip of the ball or nest on the table at some moment.
//!
//! s(t) = (x, y, z) in table axes from t₁ on, 0 before            [docs/design/physics.md §9.13: setting slip]
//! Limits: one slip; needs time stamps.

use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "setup-slip",
    role: Role::CAUSE,
    about: About {
        title: "Slip of ball or nest",
        source: "docs/design/physics.md §9.13",
        equation: "s = (x, y, z) in table axes from t₁ on, 0 before",
        symbols: "s displacement of the table-side ball or nest in table axes, µm; t₁ moment of the slip, s (shape number slip_after_s)",
        validity: "One slip; needs time stamps.",
        typical: "any",
        explanation: "The ball or the nest was moved during the measurement and stayed there.",
        cause: "Loose magnet or clamp, a knock, a collision, a cable that pulled; in the first minutes also a ball, nest or probe that settles after it was mounted. Not an error of the machine.",
        seen_by: "Returning to the first pose before and after; mount it again, wait some minutes and repeat.",
        needs: &[Need::TimeStamps],
        helps: &[Need::Return],
    },
    subjects: |_| vec![Subject::Whole],
    parameters: |scene, _| {
        if scene.has_time() {
            ["x", "y", "z"].map(|name| Parameter::new(name, Unit::UM).sudden()).into()
        } else {
            Vec::new()
        }
    },
    shapes,
    motions,
    example: Example {
        id: "setup-slip",
        shape: &[3000.0],
        values: &[("x", 8.0), ("z", -3.0)],
        view: View::Time(7200.0),
    },
    golden: Golden {
        source: "IEC 60050-103 (unit step: 0 before, 1 after)",
        derivation: "A ball is pushed 8 µm along the table's x 3000 s after the first point. It reads nothing before, −8 µm from then on, at every angle of C.",
        id: "setup-slip",
        shape: &[3000.0],
        values: &[("x", 8.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { time_s: 50.0, read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { time_s: 3049.0, read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { time_s: 3050.0, read_um: Some([-8.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment {
                position: &[("C", 90.0)],
                time_s: 7000.0,
                read_um: Some([-8.0, 0.0, 0.0]),
                ..Moment::AT_REST
            },
        ],
        within_um: 0.5,
    },
};

/// Moments tried, evenly over the readings: while nothing is read no slip has a moment.
const MOMENTS: usize = 32;

fn shapes(scene: &Scene, _: Subject) -> Shapes {
    let moment = |i: usize| scene.moment_s((i as f64 + 0.5) / MOMENTS as f64).unwrap_or_default();
    Shapes::one("slip_after_s", (0..MOMENTS).map(moment), true)
}

fn motions(scene: &Scene, _: Subject, shape: &[f64], state: &State, emit: Emit<'_>) {
    let (Some(elapsed_s), &[slip_after_s]) = (scene.elapsed_s(state), shape) else { return };
    let slipped = f64::from(u8::from(elapsed_s >= slip_after_s));
    for k in 0..3 {
        emit(k, Site::TableBall, Twist::translation(Vector3::ith(k, slipped)));
    }
}
