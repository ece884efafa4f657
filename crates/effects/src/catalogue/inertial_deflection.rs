//! Deflection under the inertia of an accelerating axis.
//!
//! Positioning: e = −c a, c compliance × mass, s².  Linear axis: tilts ω = k a across it (mass above its drive).
//! Rotary axis: δ = R(C) f v², the off-centre mass pulls outward.         [docs/design/physics.md §9.9: acceleration, centrifugal, cross-talk]
//! Limits: on the fly; below the first resonance.

use crate::subjects::{across, axis_of, carrier_from_carried, every_axis, linear_name, rotary_name};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::{State, Twist};
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "inertial-deflection",
    role: Role::CAUSE,
    about: About {
        title: "Deflection under acceleration",
        source: "docs/design/physics.md §9.9; ISO 230-1 annex on cross-talk",
        equation: "e = −c a; linear: ω = k a across the axis; rotary: δ = R f v² outward",
        symbols: "e positioning error; c compliance × mass, µm per m/s²; k tilt, µrad per m/s²; f outward pull of an off-centre mass, µm per (rad/s)²; v velocity, a acceleration",
        validity: "Read on the fly; slow against the first resonance.",
        typical: "1–10 µm per m/s²; grows with the square of the feed on a circle",
        explanation: "The machine bends while it accelerates or while an off-centre mass turns fast.",
        cause: "Mass above or next to the drive, soft drive train, unbalanced table.",
        seen_by: "Two feeds: the error grows fourfold when the feed doubles.",
        needs: &[Need::OnTheFly, Need::ChangingSpeed],
        helps: &[Need::TwoFeeds, Need::BothDirections],
    },
    subjects: every_axis,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "inertial-deflection:X",
        shape: &[],
        values: &[("along", 40.0)],
        view: View::Circle(&[3000.0, 6000.0]),
    },
    golden: Golden {
        source: "Den Hartog, Mechanical Vibrations, §2.3 (natural frequency 15.76/√δ Hz, static sag δ in mm)",
        derivation: "A drive with 50 Hz sags by (15.76/50)² mm = 99.35 µm under 1 g = 9.80665 m/s²: 10.131 µm per m/s², and stays behind its command.",
        id: "inertial-deflection:X",
        shape: &[],
        values: &[("along", 10.131)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment {
                velocity: &[("X", 100.0)],
                acceleration: &[("X", 9806.65)],
                read_um: Some([-99.35, 0.0, 0.0]),
                ..Moment::AT_REST
            },
            Moment { velocity: &[("X", 100.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.05,
    },
};

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.read_in_motion(axis.letter)) else {
        return Vec::new();
    };
    let two_feeds = axis.is_rotary() && scene.changes_speed(axis.letter);
    if !scene.accelerates(axis.letter) && !two_feeds {
        return Vec::new();
    }
    let across = across(&axis.direction);
    let (names, unit, along) = if axis.is_rotary() {
        (across.index.map(linear_name), Unit::UM_PER_RAD2_S2, Unit::URAD_PER_RAD_S2)
    } else {
        (across.index.map(rotary_name), Unit::URAD_PER_M_S2, Unit::UM_PER_M_S2)
    };
    let cross = |k: usize| Parameter::new(format!("E{}{}", names[k], axis.letter), unit);
    vec![Parameter::new("along", along), cross(0), cross(1)]
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let (v, a) = (state.velocity[axis.letter], state.acceleration[axis.letter]);
    let (site, across) = (Site::Joint(axis.letter), across(&axis.direction));
    emit(0, site, axis.positioning_twist() * -a);
    for (k, e) in [across.first, across.second].into_iter().enumerate() {
        let twist = if axis.is_rotary() {
            Twist::translation(carrier_from_carried(axis, state) * e * v * v)
        } else {
            Twist::rotation(e * a)
        };
        emit(1 + k, site, twist);
    }
}
