//! The axis of rotation moves up and down along itself: a thrust bearing out of flat.
//!
//! Displacement along the axis, a sum of cos nθ, sin nθ, n = 1, 2, 3.
//! Looks alike at every height and radius; for a table axis at zero tilt it is in Z alone.

use super::*;

pub(super) const KIND: Kind = Kind {
    name: "axial-error-motion",
    about: "the axis of rotation moves along itself, one to three times a turn",
    amplitude: "displacement, mm",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    catalogued: true,
    shape: &["cos_1", "sin_1", "cos_2", "sin_2", "cos_3", "sin_3"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    (0..6).map(|_| any_sign(rng) * rng.random_range(0.3..1.0)).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let waves: [f64; 6] = numbers(shape);
    let [_, _, along] = scene.trihedron();
    let mut lift = 0.0;
    for (n, pair) in (1..).zip(waves.chunks_exact(2)) {
        let (sin, cos) = (f64::from(n) * scene.here()).sin_cos();
        lift += pair[0] * cos + pair[1] * sin;
    }
    Disturbance::joint(scene.letter(), Twist::translation(along * lift))
}
