//! A mass off the centre of the rotary table.
//!
//! Its weight turns the table about its axis: `sin t · sin(C + φ)`, t the tilt that takes the axis off the vertical;
//! and winds up the drive of the tilting axis: `r cos t · cos(C + φ)`, the moment of the mass about that axis.
//! Looks like once a turn, growing with the tilt.

use super::super::grid::tilting_and_turning;
use super::*;

pub(super) const KIND: Kind = Kind {
    name: "unbalance",
    about: "an off-centre mass turns the tilted table and loads the tilting drive",
    amplitude: "turn of the table at 90° of tilt, rad",
    places: &[C],
    seen_in: SeenIn::StaticGrid,
    catalogued: true,
    shape: &["phase_rad", "windup_ratio"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    // The tilting drive is far stiffer than that of the table: its share is left small.
    vec![any_angle(rng), rng.random_range(-0.05..0.05)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [phase, ratio] = numbers(shape);
    let [tilting, turning] = tilting_and_turning(scene.machine);
    let (tilt, turn) = (scene.state.position[tilting], scene.here() + phase);
    scene.positioning(turning, tilt.sin() * turn.sin())
        + scene.positioning(tilting, ratio * tilt.cos() * turn.cos())
}
