//! Coning: the axis of rotation nods as it turns.
//!
//! Tilts about both directions across the axis, each a sum of cos nθ, sin nθ, n = 1, 2 [S1 §5.3: sinusoidal].
//! Looks like waves that grow with the distance of the ball from the joint, so differently at two heights.

use super::*;

pub(super) const KIND: Kind = Kind {
    name: "tilt-error-motion",
    about: "the axis of rotation nods once and twice a turn",
    amplitude: "tilt, rad",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    catalogued: true,
    shape: &["u_cos_1", "u_sin_1", "u_cos_2", "u_sin_2", "v_cos_1", "v_sin_1", "v_cos_2", "v_sin_2"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    (0..8).map(|_| any_sign(rng) * rng.random_range(0.3..1.0)).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [u1, u2, u3, u4, v1, v2, v3, v4] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let (sin_1, cos_1) = scene.here().sin_cos();
    let (sin_2, cos_2) = (2.0 * scene.here()).sin_cos();
    let tilt = u * (u1 * cos_1 + u2 * sin_1 + u3 * cos_2 + u4 * sin_2)
        + v * (v1 * cos_1 + v2 * sin_1 + v3 * cos_2 + v4 * sin_2);
    Disturbance::joint(scene.letter(), Twist::rotation(tilt))
}
