//! The chiller of the table goes on and off.
//!
//! A square wave of period P and duty d lifts the table along Z; edges rounded by the heat stored, time constant P/30.
//! P is a fifth to a third of half a run (7 min of a real one). Looks like two levels in turn. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "coolant-cycle",
    about: "the chiller goes on and off and lifts the table",
    amplitude: "lift between off and on, mm",
    places: &[Place::Machine],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["period_s", "duty", "phase_s"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let period_s = around.run_duration_s * rng.random_range(0.12..0.25);
    vec![period_s, rng.random_range(0.35..0.6), period_s * rng.random::<f64>()]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [period_s, duty, phase_s] = numbers(shape);
    let into_s = (scene.time_s() + phase_s).rem_euclid(period_s);
    let rounding_s = period_s / 30.0;
    let since_on = 1.0 - (-into_s / rounding_s).exp();
    let since_off = 1.0 - (-(into_s - duty * period_s).max(0.0) / rounding_s).exp();
    Disturbance::table(Vector3::z() * (since_on - since_off))
}
