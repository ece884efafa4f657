//! The axis of rotation wanders sideways: a bearing ring that is oval or three-lobed.
//!
//! Displacements across the axis, each of cos nθ and sin nθ, n = 2 or 3 (n = 1 cannot be distinguished from the setting).
//! Looks like two or three waves a turn, the same at every height and tilt, in the axes of what carries the axis.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "radial-error-motion",
    about: "the axis of rotation wanders sideways twice or three times a turn",
    amplitude: "displacement, mm",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["lobes", "u_cos", "u_sin", "v_cos", "v_sin"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    let [a, b, c, d] = std::array::from_fn(|_| any_sign(rng) * rng.random_range(0.3..1.0));
    vec![f64::from(rng.random_range(2..=3_u8)), a, b, c, d]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [n, u_cos, u_sin, v_cos, v_sin] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let (sin, cos) = (n * scene.here()).sin_cos();
    let sideways = u * (u_cos * cos + u_sin * sin) + v * (v_cos * cos + v_sin * sin);
    Disturbance::joint(scene.letter(), Twist::translation(sideways))
}
