//! A mass off the centre of the rotary table.
//!
//! Its place `e = (cos(C + φ), sin(C + φ), 0)` and weight `g` (both in the tilting frame) make the moment `e × g`: the part
//! about the axis turns the table against its drive (`sin t · sin(C + φ)`, t the tilt), the part across tilts it in its
//! bearing (`∝ cos t`), a little. Looks like once a turn, growing with the tilt.

use super::super::grid::tilting_and_turning;
use super::super::rotation::turned;
use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "unbalance",
    about: "an off-centre mass turns the tilted table and tilts it in its bearing",
    amplitude: "turn of the table at 90° of tilt, rad",
    places: &[C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["phase_rad", "tilt_ratio"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    vec![any_angle(rng), rng.random_range(0.05..0.4)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [phase, ratio] = numbers(shape);
    let [tilting, _] = tilting_and_turning(scene.machine);
    let [u, v, along] = scene.trihedron();
    let mass = u * (scene.here() + phase).cos() + v * (scene.here() + phase).sin();
    let machine_from_frame = match scene.machine.axis(tilting) {
        Some(axis) => turned(&axis.direction, scene.state.position[tilting] * axis.sense),
        None => nalgebra::Matrix3::identity(),
    };
    let weight = machine_from_frame.transpose() * -Vector3::z();
    let moment = mass.cross(&weight);
    let about = along * moment.dot(&along);
    Disturbance::joint(scene.letter(), Twist::rotation(about + (moment - about) * ratio))
}
