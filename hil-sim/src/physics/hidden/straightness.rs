//! A guideway is bowed.
//!
//! Sideways `b₂ (3s² − 1)/2 + b₃ (5s³ − 3s)/2` in both directions across the travel, s = −1…1 over the travel used: the
//! deviation from its own mean line, so that nothing of it is a squareness, a scale or a place.
//! Looks like a parabola or an S over one linear axis, whatever the rotary axes do.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "straightness",
    about: "a guideway is bowed and S-shaped",
    amplitude: "deviation at the ends of the travel, mm",
    places: &[X, Y, Z],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["middle_mm", "half_length_mm", "u_bow", "u_s", "v_bow", "v_s"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let (low_mm, high_mm) = around.travel;
    let line = [(low_mm + high_mm) / 2.0, (high_mm - low_mm) / 2.0];
    let bends = (0..4).map(|_| any_sign(rng) * rng.random_range(0.3..1.0));
    line.into_iter().chain(bends).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [middle_mm, half_length_mm, u_bow, u_s, v_bow, v_s] = numbers(shape);
    if half_length_mm <= 0.0 {
        return Disturbance::default();
    }
    let [u, v, _] = scene.trihedron();
    let s = (scene.here() - middle_mm) / half_length_mm;
    // Orthogonal to 1 and s over −1…1.
    let (bow, s_shape) = ((3.0 * s * s - 1.0) / 2.0, (5.0 * s.powi(3) - 3.0 * s) / 2.0);
    let sideways = u * (u_bow * bow + u_s * s_shape) + v * (v_bow * bow + v_s * s_shape);
    Disturbance::joint(scene.letter(), Twist::translation(sideways))
}
