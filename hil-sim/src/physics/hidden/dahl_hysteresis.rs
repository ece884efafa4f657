//! Friction of a seal or of grease holds the axis back and builds up only with travel (Dahl).
//!
//! Positioning error `−½ h d (1 − 2 e^(−s/s₀))`, d the direction, s the travel since the last reversal, s₀ = 40…120°.
//! Looks like backlash that needs a third of a turn to set in. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "dahl-hysteresis",
    about: "friction that builds up over a third of a turn after each reversal",
    amplitude: "width of the loop, rad",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["travel_rad"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![rng.random_range(40.0..120.0_f64).to_radians()]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [travel] = numbers(shape);
    let letter = scene.letter();
    let (d, s) = (scene.state.direction[letter], scene.state.since_reversal[letter]);
    scene.positioning(letter, -0.5 * d * (1.0 - 2.0 * (-s / travel).exp()))
}
