//! The drive of the tilting axis grows soft as it warms: the table hangs lower and lower.
//!
//! Turn about the axis and drop `(1 − e^(−T/τ)) · sin t`, T the time, t the tilt: what gravity does grows with time.
//! Looks like sag at the end of the run and like nothing at its beginning. In no catalogue.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "drift-gravity",
    about: "a drive that softens as it warms lets the tilted table hang lower with time",
    amplitude: "drop at 90° when warm, mm",
    places: &[A, B],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: false,
    shape: &["warming_s", "sign", "turn_rad_per_mm"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let warming_s = around.run_duration_s * rng.random_range(0.15..0.6);
    vec![warming_s, any_sign(rng), rng.random_range(5e-3..1.5e-2)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [warming_s, sign, turn] = numbers(shape);
    let warm = 1.0 - (-scene.time_s() / warming_s).exp();
    let hanging = sign * warm * scene.here().sin();
    let [_, _, along] = scene.trihedron();
    let hung = Twist { translation_mm: -Vector3::z() * hanging, rotation_rad: along * (turn * hanging) };
    Disturbance::joint(scene.letter(), hung)
}
