//! Lost motion of a drive measured on the motor side.
//!
//! Positioning error `½ h · direction of travel`, h the lost motion.
//! Looks like a constant difference between the two directions, through the lever of a rotary axis.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "backlash",
    about: "the axis lags by half its lost motion, the way it travels",
    amplitude: "lost motion, mm or rad",
    places: &[A, B, C, X, Y, Z],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["sign"],
    draw,
    disturb,
};

/// An axis may also be over-compensated.
fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![if rng.random::<f64>() < 0.8 { -1.0 } else { 1.0 }]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [sign] = numbers(shape);
    let letter = scene.letter();
    scene.positioning(letter, 0.5 * sign * scene.state.direction[letter])
}
