//! The axis of rotation moves up and down along itself: a thrust bearing out of flat.
//!
//! Displacement along the axis `sin(nθ + φ)`, n = 2 or 3 (most of n = 1 is a tilt of the table).
//! Looks like nothing but a lift, the same at every height and radius; for a table axis at zero tilt it is in Z alone.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "axial-error-motion",
    about: "the axis of rotation moves along itself, twice or three times a turn",
    amplitude: "displacement, mm",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["lobes", "phase_rad"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![f64::from(rng.random_range(2..=3_u8)), any_angle(rng)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [n, phase] = numbers(shape);
    let [_, _, along] = scene.trihedron();
    let lift = (n * scene.here() + phase).sin();
    Disturbance::joint(scene.letter(), Twist::translation(along * lift))
}
