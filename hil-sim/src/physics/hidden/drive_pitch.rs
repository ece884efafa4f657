//! Pitch errors of a worm wheel or last gear without a direct encoder.
//!
//! Positioning error `sin(nθ + φ) + r sin(Nθ + ψ)`: n = 3…5 waves a turn from the cutting of the wheel, N waves from its
//! teeth [S4 table 2]. Looks like encoder eccentricity with more waves. On a 30° grid the teeth alias (72 teeth read as a constant); on the fly both are seen.

use super::kind::*;

pub(super) const KIND: Kind = Kind {
    name: "drive-pitch",
    about: "pitch error of the worm wheel: a few slow waves and one wave a tooth",
    amplitude: "positioning error of the slow wave, rad",
    places: &[A, B, C],
    seen_in: SeenIn::StaticGrid,
    at_encoder: false,
    catalogued: true,
    shape: &["lobes", "lobes_phase_rad", "teeth", "teeth_ratio", "teeth_phase_rad"],
    draw,
    disturb,
};

/// Of a worm wheel whose file names no teeth.
const USUAL_TEETH: f64 = 72.0;

fn draw(rng: &mut ChaCha8Rng, around: &Circumstances<'_>) -> Vec<f64> {
    let axis = match around.place {
        Place::Axis(letter) => around.machine.axis(letter),
        _ => None,
    };
    let teeth = axis.and_then(|axis| axis.facts.gear_teeth).unwrap_or(USUAL_TEETH);
    let lobes = f64::from(rng.random_range(3..=5_u8));
    vec![lobes, any_angle(rng), teeth, rng.random_range(0.2..0.5), any_angle(rng)]
}

fn disturb(scene: &Scene<'_>, shape: &[f64]) -> Disturbance {
    let [lobes, lobes_phase, teeth, ratio, teeth_phase] = numbers(shape);
    let theta = scene.here();
    let error = (lobes * theta + lobes_phase).sin() + ratio * (teeth * theta + teeth_phase).sin();
    scene.positioning(scene.letter(), error)
}
