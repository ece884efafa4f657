//! The ring of an angular encoder sits eccentrically and is a little oval.
//!
//! Positioning error `sin(θ + φ₁) + r sin(2θ + φ₂)` [docs/design/physics.md §9.4: 412.5·e/D arcsec].
//! Looks like one and two waves a turn along the direction of turning.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "encoder-eccentricity",
    about: "the encoder ring is eccentric and oval",
    amplitude: "positioning error of the first wave, rad",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["phase_1_rad", "ratio_2", "phase_2_rad"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![any_angle(rng), rng.random_range(0.1..0.4), any_angle(rng)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [phase_1, ratio, phase_2] = numbers(shape);
    let theta = scene.here();
    scene.positioning(scene.letter(), (theta + phase_1).sin() + ratio * (2.0 * theta + phase_2).sin())
}
