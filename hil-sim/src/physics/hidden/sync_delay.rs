//! The rotary axes are interpolated later than the linear axes.
//!
//! The rotary axes are where they were τ ago when the linear axes are where they should be: positioning error
//! `−v τ` of every rotary axis [docs/design/physics.md §9.8: 21 µm per ms at 360°/min, R 200 mm]. Looks like servo lag of all of them
//! at once: ∝ v, flips with direction, nothing at rest. While one rotary axis turns alone it *is* that axis' servo lag.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "sync-delay",
    about: "rotary axes come later than linear axes",
    amplitude: "delay, s",
    places: &[Place::Machine],
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
    let late = |letter| scene.positioning(letter, -sign * scene.state.velocity[letter]);
    Joint::ROTARY.into_iter().map(late).fold(Disturbance::default(), |sum, each| sum + each)
}
