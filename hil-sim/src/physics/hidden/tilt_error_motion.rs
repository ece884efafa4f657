//! Coning: the axis of rotation nods as it turns.
//!
//! Tilts about both directions across the axis, each of cos nθ and sin nθ, n = 1 or 2 [S1 §5.3: sinusoidal].
//! Looks like waves that grow with the distance of the ball from the joint, so differently at two heights.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "tilt-error-motion",
    about: "the axis of rotation nods once or twice a turn",
    amplitude: "tilt, rad",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["lobes", "u_cos", "u_sin", "v_cos", "v_sin"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    // A phasor that turns against the axis and a smaller one that turns with it (n = 1 of that is invisible to a table ball).
    let (against, with) = (any_angle(rng), any_angle(rng));
    let r = rng.random_range(0.2..0.6);
    let lobes = f64::from(rng.random_range(1..=2_u8));
    let u_cos = against.cos() + r * with.cos();
    let u_sin = -against.sin() - r * with.sin();
    let v_cos = -against.sin() + r * with.sin();
    let v_sin = -against.cos() + r * with.cos();
    vec![lobes, u_cos, u_sin, v_cos, v_sin]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [n, u_cos, u_sin, v_cos, v_sin] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let (sin, cos) = (n * scene.here()).sin_cos();
    let tilt = u * (u_cos * cos + u_sin * sin) + v * (v_cos * cos + v_sin * sin);
    Disturbance::joint(scene.letter(), Twist::rotation(tilt))
}
