//! The axis of rotation wanders sideways: a bearing ring that is oval and three-lobed.
//!
//! Displacements across the axis, each a sum of cos nθ, sin nθ, n = 2, 3 (n = 1 cannot be told from the setting).
//! Looks alike at every height and every tilt of what carries the axis, in the carrier's axes.

use super::*;

pub(super) const KIND: Kind = Kind {
    name: "radial-error-motion",
    about: "the axis of rotation wanders sideways twice and three times a turn",
    amplitude: "displacement, mm",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    catalogued: true,
    shape: &["u_cos_2", "u_sin_2", "u_cos_3", "u_sin_3", "v_cos_2", "v_sin_2", "v_cos_3", "v_sin_3"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    (0..8).map(|_| any_sign(rng) * rng.random_range(0.3..1.0)).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [u1, u2, u3, u4, v1, v2, v3, v4] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let (sin_2, cos_2) = (2.0 * scene.here()).sin_cos();
    let (sin_3, cos_3) = (3.0 * scene.here()).sin_cos();
    let sideways = u * (u1 * cos_2 + u2 * sin_2 + u3 * cos_3 + u4 * sin_3)
        + v * (v1 * cos_2 + v2 * sin_2 + v3 * cos_3 + v4 * sin_3);
    Disturbance::joint(scene.letter(), Twist::translation(sideways))
}
