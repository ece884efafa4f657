//! Factors that depend on linear positions, and on how axes move while they are read.

use super::draft::{Draft, companions, products};
use crate::Experiment;
use crate::spectrum::Wave;
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_effects::Scene;

pub(super) fn linear(experiment: &Experiment, drafts: &mut Vec<Draft>) {
    let letters = experiment.machine().linear_joints();
    for (i, first) in letters.iter().enumerate() {
        let one = |factor: String, order: usize, words: String| {
            Draft::new("linear", order, vec![factor], words).ground()
        };
        drafts.push(one(format!("dir{first}"), 1, format!("changing sign with the direction of {first}")));
        drafts.push(one(format!("{first}/100"), 1, format!("proportional to {first}")));
        for second in &letters[i..] {
            drafts.push(one(format!("{first}*{second}/10000"), 2, format!("with {first} times {second}")));
        }
        let (low, high) = experiment.scene.position_range[*first];
        let travel = high - low;
        if travel > 1.0 {
            let rates: Vec<f64> = (0..6).map(|i| TAU / travel * (1.0 + 0.75 * f64::from(i))).collect();
            let columns = vec![format!("cos(per_mm*{first})"), format!("sin(per_mm*{first})")];
            drafts.push(
                Draft::new("linear", 2, columns, format!("repeating along {first}"))
                    .with("per_mm", (0.7 * TAU / travel, 6.0 * TAU / travel), &rates)
                    .ground(),
            );
        }
    }
}

/// A wave that the spectrum of the residual shows, whole or broken; its period is known to a few of its uncertainties.
pub(super) fn wave(joint: Joint, wave: &Wave) -> Draft {
    let omega = wave.omega();
    let u = omega * wave.u / wave.value;
    // An idea of its own: another period is another wave.
    let idea = format!("wave {joint} {omega:.6}");
    let within = (omega - WITHIN_U * u, omega + WITHIN_U * u);
    if joint.is_rotary() {
        let columns = vec![format!("cos(cycles*{joint})"), format!("sin(cycles*{joint})")];
        let words = format!("{CYCLES} per turn of {joint}");
        return Draft::new(idea, 2, columns, words).with("cycles", within, &[omega]);
    }
    let columns = vec![format!("cos(per_mm*{joint})"), format!("sin(per_mm*{joint})")];
    let words = format!("repeating along {joint} every {PERIOD} mm");
    Draft::new(idea, 2, columns, words).with("per_mm", within, &[omega]).ground()
}

/// Stands in words for the period that the fit brings a wave to ([`crate::diagnosis::words::placed`]).
pub const PERIOD: &str = "so many";
/// The same for its cycles per turn.
pub const CYCLES: &str = "so often";

/// Uncertainties of a period within which it is refined.
const WITHIN_U: f64 = 4.0;

/// While axes move: with speed and acceleration.
pub(super) fn moving(rotary: &[Joint], scene: &Scene, drafts: &mut Vec<Draft>) {
    let fastest = |letter: Joint| scene.speed_range[letter].1;
    for letter in scene.machine.joints().into_iter().filter(|&letter| fastest(letter) > 0.0) {
        for (order, factors, words) in companions(rotary) {
            for (factor, how) in [
                (format!("v{letter}"), format!("in proportion to the speed of {letter}")),
                (format!("v{letter}^2"), format!("with the square of the speed of {letter}")),
                (format!("a{letter}"), format!("in proportion to the acceleration of {letter}")),
            ] {
                let columns = products(&[factor], &factors);
                drafts.push(Draft::new(
                    format!("speed {letter}"),
                    order + 1,
                    columns,
                    format!("{how}{words}"),
                ));
            }
        }
    }
}
