//! A bearing of the tilting axis changes its seat: before one tilt it rests on one side, after it on the other.
//!
//! `½ (1 + tanh((t − t₀)/w))`, t₀ = −40…40°, w = 4…12°: a displacement across the axis and a tilt about it.
//! Looks like two levels with a soft step between them, the same from both sides. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "soft-step",
    about: "a bearing changes its seat at one tilt",
    amplitude: "displacement from one seat to the other, mm",
    places: &[A, B],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["at_rad", "softness_rad", "across_rad", "tilt_rad_per_mm"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    let at_rad = rng.random_range(-40.0..40.0_f64).to_radians();
    let softness_rad = rng.random_range(4.0..12.0_f64).to_radians();
    vec![at_rad, softness_rad, any_angle(rng), any_sign(rng) * rng.random_range(1e-3..3e-3)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [at, softness, across, tilt] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let seated = 0.5 * (1.0 + ((scene.here() - at) / softness).tanh());
    let moved = Twist { translation_mm: u * across.cos() + v * across.sin(), rotation_rad: u * tilt };
    Disturbance::joint(scene.letter(), moved * seated)
}
