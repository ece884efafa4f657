//! The position loop of one axis lags behind its command.
//!
//! Positioning error `−v / Kv` [docs/design/physics.md §9.8]; with unlike Kv the path of several axes is distorted.
//! Looks like an error proportional to speed that flips with direction; nothing at rest.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "servo-lag",
    about: "one axis lags behind its command in proportion to its speed",
    amplitude: "1/Kv in excess of the other axes, s",
    places: &[C, X, Y, Z],
    seen_in: SeenIn::OnTheFly,
    at_encoder: true,
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
    let letter = scene.letter();
    scene.positioning(letter, -sign * scene.state.velocity[letter])
}
