//! The column and the spindle warm up: the tool moves away with two time constants.
//!
//! `u(t) = a (1 − e^(−t/τ₁)) + b (1 − e^(−t/τ₂))`, machine axes, a and b different directions.
//! Looks like a drift that slows down, the same in every pose; settings of later setups swallow most of it.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "thermal-drift",
    about: "the tool side grows with two time constants",
    amplitude: "final displacement of the fast part, mm",
    places: &[Place::Machine],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["fast_s", "slow_s", "fast_x", "fast_y", "fast_z", "slow_x", "slow_y", "slow_z"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let fast_s = around.run_duration_s * rng.random_range(0.1..0.25);
    let slow_s = around.run_duration_s * rng.random_range(0.4..1.0);
    let a = any_direction(rng);
    let b = any_direction(rng) * rng.random_range(0.5..1.5);
    vec![fast_s, slow_s, a.x, a.y, a.z, b.x, b.y, b.z]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [fast_s, slow_s, ax, ay, az, bx, by, bz] = numbers(shape);
    let t_s = scene.time_s();
    let fast = Vector3::new(ax, ay, az) * (1.0 - (-t_s / fast_s).exp());
    let slow = Vector3::new(bx, by, bz) * (1.0 - (-t_s / slow_s).exp());
    Disturbance::tool(fast + slow)
}
