//! Factors that depend on time and temperature.

use super::draft::{Draft, companions, products};
use std::f64::consts::{PI, TAU};
use trunnion_core::Joint;
use trunnion_effects::Scene;

/// Moments of a switch during the run, evenly over the readings.
const MOMENTS: usize = 13;

/// Warming up and wandering.
pub(super) fn settling(duration_s: f64, rotary: &[Joint], drafts: &mut Vec<Draft>) {
    let limits = (0.04 * duration_s, 2.0 * duration_s);
    for (order, factors, words) in companions(rotary) {
        let columns = products(&[format!("(t/{duration_s:.0} - 0.5)")], &factors);
        drafts.push(Draft::new("time", order + 1, columns, format!("growing with time{words}")));
        let columns = products(&["(1 - exp(-t/tau))".into()], &factors);
        drafts.push(Draft::new("time", order + 2, columns, format!("settling with time{words}")).with(
            "tau",
            limits,
            &[0.06, 0.15, 0.4].map(|share| share * duration_s),
        ));
    }
}

/// Switching once, and coming and going.
pub(super) fn switching(duration_s: f64, scene: &Scene, drafts: &mut Vec<Draft>) {
    let moment = |i: usize| scene.moment_s(i as f64 / MOMENTS as f64);
    let moments: Vec<f64> = (1..MOMENTS).filter_map(moment).collect();
    drafts.push(Draft::new("clock", 1, vec!["step(t - when)".into()], "switching at one moment").with(
        "when",
        (0.0, duration_s),
        &moments,
    ));
    // Faster than two points a period is not distinguishable from slower.
    let fastest = scene.time_step_s.map_or(PI * 20.0 / duration_s, |step_s| PI / step_s);
    let rate = |cycles: f64| TAU * cycles / duration_s;
    let rates = |cycles: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        cycles.map(rate).filter(|rate| *rate < fastest).collect()
    };
    let coarse = rates(&mut (0..9).map(|i| 2.0 * 1.35_f64.powi(i)));
    let fine = rates(&mut (3..26).map(|half_cycles| 0.5 * f64::from(half_cycles)));
    if coarse.is_empty() || fine.is_empty() {
        return;
    }
    let limits = (rate(1.2), rate(25.0).min(fastest));
    let wave = || {
        let columns = vec!["cos(rate*t)".into(), "sin(rate*t)".into()];
        Draft::new("clock", 2, columns, "coming and going with time")
    };
    drafts.push(wave().with("rate", limits, &coarse));
    drafts.push(wave().ground().with("rate", limits, &fine));
    let phases: Vec<f64> = (0..8).map(|i| TAU * f64::from(i) / 8.0).collect();
    let square = "step(sin(rate*t + phase) - duty)".to_string();
    drafts.push(
        Draft::new("clock", 3, vec![square], "switching on and off at regular times")
            .with("rate", limits, &coarse)
            .with("phase", (0.0, TAU), &phases)
            .with("duty", (-0.95, 0.95), &[-0.5, 0.0, 0.5])
            .only_refined(),
    );
}

pub(super) fn temperatures(rotary: &[Joint], scene: &Scene, drafts: &mut Vec<Draft>) {
    for channel in &scene.channels {
        for (order, factors, words) in companions(rotary) {
            let columns = products(&[format!("T_{channel}")], &factors);
            let words = format!("with the temperature {channel}{words}");
            drafts.push(Draft::new("temperature", order + 1, columns, words));
        }
    }
}
