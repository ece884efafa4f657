//! A carriage rolls, pitches and yaws while it travels.
//!
//! Turns `s · (a, b, c)` about the three directions of the machine, s = −1…1 over the travel used [S2 eq. 1: EAX, EBX, ECX].
//! Looks like a level that leans with the position; at the ball the turn acts with the arm to the guide.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "angular-motion",
    about: "a carriage rolls, pitches and yaws",
    amplitude: "turn at the ends of the travel, rad",
    places: &[X, Y, Z],
    seen_in: SeenIn::Turns,
    at_encoder: false,
    catalogued: true,
    shape: &["middle_mm", "half_length_mm", "about_x", "about_y", "about_z"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let (low_mm, high_mm) = around.travel;
    let line = [(low_mm + high_mm) / 2.0, (high_mm - low_mm) / 2.0];
    let turns = (0..3).map(|_| any_sign(rng) * rng.random_range(0.3..1.0));
    line.into_iter().chain(turns).collect()
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [middle_mm, half_length_mm, about_x, about_y, about_z] = numbers(shape);
    if half_length_mm <= 0.0 {
        return Disturbance::default();
    }
    let s = (scene.here() - middle_mm) / half_length_mm;
    Disturbance::joint(scene.letter(), Twist::rotation(Vector3::new(about_x, about_y, about_z) * s))
}
