//! The six component errors of a linear axis as smooth functions of its position.
//!
//! EXX(x) = Σ aₙ Pₙ(s), n = 1…5; EYX, EZX n = 2…5; EAX, EBX, ECX n = 1…5; s = x scaled to −1…1 over the measured range, Pₙ
//! Legendre        [S2 eq. 1–2, §3.5; 21 error components with the squarenesses of `location-errors` or `squareness`]
//! A description rather than a cause: it takes the place of `linear-scale`, `straightness` and `angular-motion` of the axis when a
//! volume is measured. Limits: smooth guideways; periodic errors of a screw need their own effect.

use super::straightness::scaled;
use crate::legendre::legendre;
use crate::scene::MOST_PLACES;
use crate::subjects::{across, axis_of, every_slide, linear_name};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use nalgebra::Vector3;
use trunnion_core::{Joint, State, Twist};
use trunnion_machine::{Axis, Site};

/// Highest order of the polynomials; n places carry order n − 1 at most.
const HIGHEST: usize = MOST_PLACES - 1;

fn highest(scene: &Scene, letter: Joint) -> usize {
    HIGHEST.min(scene.places_at_one_pose[letter].saturating_sub(1))
}

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "component-errors",
    role: Role::Description,
    about: About {
        title: "Component errors of a linear axis over its travel",
        source: "S2 eq. 1–2, §3.5; ISO 230-1",
        equation: "EXX = Σ₁⁵ aₙ Pₙ(s), EYX and EZX from n = 2, EAX, EBX, ECX from n = 1; s = −1…1 over the measured range",
        symbols: "E errors of position, straightness (µm), roll, pitch and yaw (µrad); aₙ amplitudes; Pₙ Legendre polynomials; s coordinate scaled to −1…1",
        validity: "Smooth guideways over the measured range. Takes the place of linear-scale, straightness and angular-motion of the same axis.",
        typical: "1–10 µm, 10–30 µrad",
        explanation: "The carriage leaves its ideal line and turns a little while it travels; the error is given for every position. Fewer than six places carry fewer orders.",
        cause: "Guideways, scale or screw; the course over the travel shows which.",
        seen_by: "A measurement of the volume: tracking interferometer, ball plate, diagonals with other tests.",
        needs: &[Need::Travel, Need::Volume],
        helps: &[Need::TwoHeights],
    },
    subjects: every_slide,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "component-errors:X",
        shape: &[],
        values: &[("EXX.P1", 8.0), ("EYX.P2", 4.0), ("ECX.P3", 15.0)],
        view: View::Circle(&[3000.0]),
    },
    golden: Golden {
        source: "Abramowitz & Stegun table 8.1 (P₄(0.5) = −0.28906)",
        derivation: "10 µm of P₄ over −200…200 mm: 10 µm at the ends, −2.8906 µm at three quarters of the range.",
        id: "component-errors:X",
        shape: &[],
        values: &[("EYX.P4", 10.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { position: &[("X", -200.0)], read_um: Some([0.0, 10.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", -100.0)], read_um: Some([0.0, -2.8906, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 0.0)], ..Moment::AT_REST },
            Moment { position: &[("X", 50.0)], ..Moment::AT_REST },
            Moment { position: &[("X", 100.0)], read_um: Some([0.0, -2.8906, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("X", 200.0)], read_um: Some([0.0, 10.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.0005,
    },
};

/// Of each component: its symbol, its twist per unit, its unit, its lowest order.
fn components(axis: &Axis) -> [(String, Twist, Unit, usize); 6] {
    let across = across(&axis.direction);
    let [first, second, along] = across.index;
    let translation = |k: usize, twist: Vector3<f64>, lowest: usize| {
        (format!("E{}{}", linear_name(k), axis.letter), Twist::translation(twist), Unit::UM, lowest)
    };
    let rotation = |k: usize| {
        let name = format!("E{}{}", Joint::ROTARY[k], axis.letter);
        (name, Twist::rotation(Vector3::ith(k, 1.0)), Unit::URAD, 1)
    };
    [
        translation(along, axis.positioning_twist().translation_mm, 1),
        translation(first, across.first, 2),
        translation(second, across.second, 2),
        rotation(0),
        rotation(1),
        rotation(2),
    ]
}

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    let Some(axis) = axis_of(&scene.machine, subject).filter(|axis| scene.measures_volume(axis.letter))
    else {
        return Vec::new();
    };
    let highest = highest(scene, axis.letter);
    let orders = |(name, _, unit, lowest): (String, Twist, Unit, usize)| {
        (lowest..=highest).map(move |n| Parameter::new(format!("{name}.P{n}"), unit))
    };
    components(axis).into_iter().flat_map(orders).collect()
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let legendre: [f64; HIGHEST + 1] = legendre(scaled(scene, axis.letter, state));
    let mut parameter = 0;
    for (_, twist, _, lowest) in components(axis) {
        for value in &legendre[lowest..=highest(scene, axis.letter)] {
            emit(parameter, Site::Joint(axis.letter), twist * *value);
            parameter += 1;
        }
    }
}
