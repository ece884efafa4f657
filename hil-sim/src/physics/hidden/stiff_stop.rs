//! A cover or a stop of rubber is met beyond an angle of the tilting axis, on both sides.
//!
//! `max(0, |t| − t₀)`, t₀ = 50…60°: a kink. It pushes the table along the machine's Z and winds up the drive.
//! Looks like sag at the ends of travel but nothing before. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "stiff-stop",
    about: "a stop is met beyond 50 to 60 degrees of tilt",
    amplitude: "push, mm per rad beyond the angle",
    places: &[A, B],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["from_rad", "sign", "windup_rad_per_mm"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![rng.random_range(50.0..60.0_f64).to_radians(), any_sign(rng), rng.random_range(0.0..2e-3)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [from, sign, windup] = numbers(shape);
    let tilt = scene.here();
    let beyond = (tilt.abs() - from).max(0.0);
    let [_, _, along] = scene.trihedron();
    let pushed = Twist {
        translation_mm: Vector3::z() * (sign * beyond),
        rotation_rad: along * (-tilt.signum() * windup * beyond),
    };
    Disturbance::joint(scene.letter(), pushed)
}
