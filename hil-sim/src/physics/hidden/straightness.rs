//! A guideway is bowed.
//!
//! Sideways `b₂ s² + b₃ s³` in both directions across the travel, `s = x / 200 mm`.
//! Looks like a parabola or an S over one linear axis, whatever the rotary axes do.

use super::*;

pub(super) const KIND: Kind = Kind {
    name: "straightness",
    about: "a guideway is bowed and S-shaped",
    amplitude: "deviation 200 mm from the middle, mm",
    places: &[X, Y, Z],
    seen_in: SeenIn::StaticGrid,
    catalogued: true,
    shape: &["u_bow", "u_s", "v_bow", "v_s"],
    draw,
    disturb,
};

const HALF_LENGTH_MM: f64 = 200.0;

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    (0..4).map(|_| any_sign(rng) * rng.random_range(0.3..1.0)).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [u_bow, u_s, v_bow, v_s] = numbers(shape);
    let [u, v, _] = scene.trihedron();
    let s = scene.here() / HALF_LENGTH_MM;
    let sideways = u * (u_bow * s.powi(2) + u_s * s.powi(3)) + v * (v_bow * s.powi(2) + v_s * s.powi(3));
    Disturbance::joint(scene.letter(), Twist::translation(sideways))
}
