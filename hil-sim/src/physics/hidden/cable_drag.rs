//! Hoses of the table go taut beyond an angle of the tilting axis and pull.
//!
//! `s = (√(q² + w²) + q)/2`, `q = ±(t − t₀)`: zero before t₀, a straight pull after it, smooth over w.
//! The table is pulled one way and a little turned. Looks like an effect on one side only. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "cable-drag",
    about: "hoses go taut beyond a tilt and pull the table one way",
    amplitude: "pull, mm per rad beyond the angle",
    places: &[A, B],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["side", "from_rad", "softness_rad", "pull_x", "pull_y", "pull_z", "turn_rad_per_mm"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    let from_rad = rng.random_range(10.0..45.0_f64).to_radians();
    let softness_rad = rng.random_range(5.0..12.0_f64).to_radians();
    let pull = any_direction(rng);
    let turn_rad_per_mm = any_sign(rng) * rng.random_range(1e-3..3e-3);
    vec![any_sign(rng), from_rad, softness_rad, pull.x, pull.y, pull.z, turn_rad_per_mm]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [side, from, softness, x, y, z, turn] = numbers(shape);
    let q = side * scene.here() - from;
    let taut = 0.5 * (q.hypot(softness) + q);
    let [_, _, along] = scene.trihedron();
    let pulled = Twist { translation_mm: Vector3::new(x, y, z), rotation_rad: along * turn };
    Disturbance::joint(scene.letter(), pulled * taut)
}
