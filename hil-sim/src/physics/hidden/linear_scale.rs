//! A linear scale is too long or too short.
//!
//! Positioning error `s · x`, x the commanded position [S2 eq. 1: EXX].
//! Looks like a stretch of the volume along one direction.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "linear-scale",
    about: "a linear scale is too long or too short",
    amplitude: "relative error of scale",
    places: &[X, Y, Z],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["sign"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![any_sign(rng)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [sign] = numbers(shape);
    scene.positioning(scene.letter(), sign * scene.here())
}
