//! Eccentric graduation of the angular encoder.
//!
//! e(q) = a₁ cos q + b₁ sin q + a₂ cos 2q + b₂ sin 2q on the positioning error        [S4 table 2; docs/design/physics.md §9.4]
//! One reading head on a disc of diameter D whose centre is e off: amplitude 2e/D = 412.5·e[µm]/D[mm] arcsec, once a turn;
//! an oval or tilted disc, or two heads, give the second order. Limits: graduation fixed to the axis.

use crate::subjects::{axis_of, every_rotary};
use crate::{
    About, Effect, Emit, Example, Golden, Moment, Need, Parameter, Role, Scene, Shapes, Subject, Unit, View,
};
use trunnion_core::State;
use trunnion_machine::Site;

pub(crate) static EFFECT: Effect = Effect {
    phenomenon: "encoder-eccentricity",
    role: Role::Natural,
    about: About {
        title: "Eccentric or oval angular encoder",
        source: "S4 table 2 (rotary encoder); docs/design/physics.md §9.4",
        equation: "e = a₁ cos q + b₁ sin q + a₂ cos 2q + b₂ sin 2q; an eccentricity e on diameter D gives 2e/D",
        symbols: "e positioning error, µrad; q angle of the axis; a, b amplitudes, µrad; e eccentricity and D diameter of the graduation",
        validity: "Graduation fixed to the axis; first and second order.",
        typical: "412.5·e[µm]/D[mm] arcsec: 20 µrad for 1 µm on 100 mm",
        explanation: "The axis turns a little too far and then too little, once or twice a turn.",
        cause: "Errors in the rotary encoder: disc mounted off centre or tilted, or one of two heads out of use.",
        seen_by: "The axis turned over its whole range with the ball far from its line; another load separates it from gravity wind-up.",
        needs: &[Need::Travel],
        helps: &[Need::TwoRadii, Need::AnotherLoad],
    },
    subjects: every_rotary,
    parameters,
    shapes: |_, _| Shapes::none(),
    motions,
    example: Example {
        id: "encoder-eccentricity:C",
        shape: &[],
        values: &[("cos1", 20.0), ("sin2", 10.0)],
        view: View::Poses,
    },
    golden: Golden {
        source: "Heidenhain, Angle Encoders, measuring accuracy (±412 · e[µm]/D[mm] arcsec)",
        derivation: "1 µm on 100 mm: 4.12″ = 20 µrad; at 150 mm from C 3 µm along the tangent, the other way half a turn later.",
        id: "encoder-eccentricity:C",
        shape: &[],
        values: &[("cos1", 20.0)],
        balls_mm: &[[150.0, 0.0, 60.0]],
        moments: &[
            Moment { read_um: Some([0.0, -3.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 90.0)], read_um: Some([0.0, 0.0, 0.0]), ..Moment::AT_REST },
            Moment { position: &[("C", 180.0)], read_um: Some([0.0, 3.0, 0.0]), ..Moment::AT_REST },
        ],
        within_um: 0.005,
    },
};

/// Amplitude of the angle error of one reading head, rad, for a graduation off centre on a disc.
pub fn encoder_amplitude_rad(eccentricity_mm: f64, grating_diameter_mm: f64) -> f64 {
    2.0 * eccentricity_mm / grating_diameter_mm
}

fn parameters(scene: &Scene, subject: Subject) -> Vec<Parameter> {
    match axis_of(&scene.machine, subject) {
        Some(axis) if scene.moves(axis.letter) => {
            ["cos1", "sin1", "cos2", "sin2"].map(|name| Parameter::new(name, Unit::URAD)).into()
        }
        _ => Vec::new(),
    }
}

fn motions(scene: &Scene, subject: Subject, _: &[f64], state: &State, emit: Emit<'_>) {
    let Some(axis) = axis_of(&scene.machine, subject) else { return };
    let (q, site) = (state.position[axis.letter], Site::Joint(axis.letter));
    for (i, n) in [1.0, 2.0].into_iter().enumerate() {
        emit(2 * i, site, axis.positioning_twist() * (n * q).cos());
        emit(2 * i + 1, site, axis.positioning_twist() * (n * q).sin());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_micrometre_off_on_100_mm_gives_4_125_arc_seconds() {
        // 412.5·e[µm]/D[mm] arcsec: the rule of encoder makers (Heidenhain, "Angle encoders", measuring accuracy: ±412·e/D).
        let arcsec = encoder_amplitude_rad(1e-3, 100.0).to_degrees() * 3600.0;
        assert!((arcsec - 4.125).abs() < 1e-3, "{arcsec}");
    }
}
