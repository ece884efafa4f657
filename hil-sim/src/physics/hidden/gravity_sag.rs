//! Sag of the tilting frame and its table under their weight.
//!
//! `u = R_t K⁻¹ R_tᵀ g − K⁻¹ g`, `g = (0, 0, −1)`, K⁻¹ symmetric in the frame's own axes (across, along the tilting
//! axis, upright) and stiffest along the axis; plus the wind-up of the drive, `w (sin(t + φ) − sin φ)`, t the tilt.
//! Looks like 1 − cos 2t and sin 2t in the direction of gravity and across, the same at every table angle. Zero at t = 0.

use super::super::rotation::turned;
use super::kind::*;
use nalgebra::Matrix3;

pub(super) const KIND: Kind = Kind {
    name: "gravity-sag",
    about: "the tilting frame bends under its weight, unlike in different directions",
    amplitude: "compliance times weight, mm",
    places: &[A, B],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["across", "along", "upright", "across_upright", "windup_rad_per_mm", "windup_phase_rad"],
    draw,
    disturb,
};

fn draw(rng: &mut ChaCha8Rng, _: &Circumstances<'_>) -> Vec<f64> {
    let across = rng.random_range(0.8..1.3);
    let upright = rng.random_range(0.3..0.6);
    let along = rng.random_range(0.1..0.3);
    let coupling = any_sign(rng) * rng.random_range(0.05..0.25);
    let windup_rad_per_mm = any_sign(rng) * rng.random_range(1e-3..3e-3);
    vec![across, along, upright, coupling, windup_rad_per_mm, rng.random_range(-0.6..0.6)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [across, along, upright, coupling, windup, phase] = numbers(shape);
    let Some(axis) = scene.machine.axis(scene.letter()) else { return Disturbance::default() };
    let tilt = scene.here() * axis.sense;
    let k = axis.direction.into_inner();
    let z = Vector3::z();
    let x = k.cross(&z);
    let compliance: Matrix3<f64> = x * x.transpose() * across
        + k * k.transpose() * along
        + z * z.transpose() * upright
        + (x * z.transpose() + z * x.transpose()) * coupling;
    let g = -z;
    let carrier_from_frame = turned(&k, tilt);
    let sag = carrier_from_frame * compliance * carrier_from_frame.transpose() * g - compliance * g;
    let wound = windup * ((tilt + phase).sin() - phase.sin());
    Disturbance::joint(axis.letter, Twist { translation_mm: sag, rotation_rad: k * wound })
}
