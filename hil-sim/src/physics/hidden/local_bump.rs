//! A dent in a raceway lifts the table where a roller runs over it.
//!
//! `exp(−½ ((θ − θ₀)/w)²)` along the axis and a tilt with it, w = 18…26°, θ taken round the circle.
//! Looks like one place of one axis. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "local-bump",
    about: "a dent in a raceway lifts and tilts the table at one angle",
    amplitude: "lift, mm",
    places: &[C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["at_rad", "width_rad", "tilt_rad_per_mm"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    let width_rad = rng.random_range(18.0..26.0_f64).to_radians();
    vec![any_angle(rng), width_rad, rng.random_range(1e-3..4e-3)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [at, width, tilt] = numbers(shape);
    let away = (scene.here() - at).sin().atan2((scene.here() - at).cos());
    let over = (-0.5 * (away / width).powi(2)).exp();
    let [u, _, along] = scene.trihedron();
    let lifted = Twist { translation_mm: along, rotation_rad: u * tilt };
    Disturbance::joint(scene.letter(), lifted * over)
}
