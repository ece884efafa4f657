//! An axis sticks when it turns round and catches up with travel.
//!
//! Positioning error `−h · direction · e^(−s/s₀)`, s travel since the reversal [docs/design/physics.md §5, §9.7]; only while the axis moves.
//! Looks like a short pulse where an axis turns round: the quadrant glitch of a circle.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "reversal-spike",
    about: "one axis sticks after it turned round and catches up with travel",
    amplitude: "height of the spike, mm or rad",
    places: &[C, X, Y, Z, A],
    seen_in: SeenIn::OnTheFly,
    at_encoder: true,
    catalogued: true,
    shape: &["decay"],
    draw,
    disturb,
};

/// Travel after which the spike has fallen to 37 %, as a share of the travel of the cycle.
const DECAY: std::ops::Range<f64> = 0.005..0.02;

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let (low, high) = around.travel;
    vec![(high - low).max(1e-3) * rng.random_range(DECAY)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [decay] = numbers(shape);
    let letter = scene.letter();
    if scene.state.velocity[letter] == 0.0 {
        return Disturbance::default();
    }
    let stuck = (-scene.state.since_reversal[letter].abs() / decay.max(f64::MIN_POSITIVE)).exp();
    scene.positioning(letter, -scene.state.direction[letter] * stuck)
}
