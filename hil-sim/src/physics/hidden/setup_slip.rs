//! Ball or nest slips in its holder during the run.
//!
//! From time t₀ on, in one setup, the ball sits elsewhere: a step fixed to the table.
//! Looks like a jump that turns with the table.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "setup-slip",
    about: "ball or nest slips in one setup at one moment",
    amplitude: "step, mm",
    places: &[Place::Machine],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["setup", "at_s", "x", "y", "z"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let setups = around.setups.max(1);
    let setup = rng.random_range(0..setups) as f64;
    // Well inside the setup's share of the run, so that there is a before and an after.
    let at_s = around.run_duration_s * (setup + rng.random_range(0.25..0.6)) / setups as f64;
    let step = any_direction(rng);
    vec![setup, at_s, step.x, step.y, step.z]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [setup, at_s, x, y, z] = numbers(shape);
    if scene.setup as f64 != setup || scene.time_s() < at_s {
        return Disturbance::default();
    }
    Disturbance::setting(Vector3::new(x, y, z))
}
