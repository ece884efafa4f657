//! ISO 230-7 values on the simulator.

use super::bench::{by_method, cycle, cycle_text, measure, noise, truth, value};
use trunnion_methods::Findings;
use trunnion_methods::recipes::Convention;

const UM: f64 = 1e-3;
const URAD: f64 = 1e-6;

/// Radial 3 lobes of 1 µm along X and 0.5 µm along Y, axial 2 lobes of 0.4 µm, tilt 4 µrad of 2 lobes about X alone.
const MOTIONS: &str = "[[hidden]]\nid = \"radial-error-motion:C\"\namplitude = 1e-3\n\
     shape = { lobes = 3.0, u_cos = 1.0, u_sin = 0.0, v_cos = 0.0, v_sin = 0.5 }\n\
     [[hidden]]\nid = \"axial-error-motion:C\"\namplitude = 0.4e-3\nshape = { lobes = 2.0, phase_rad = 0.7 }\n\
     [[hidden]]\nid = \"tilt-error-motion:C\"\namplitude = 4e-6\n\
     shape = { lobes = 2.0, u_cos = 1.0, u_sin = 0.0, v_cos = 0.0, v_sin = 0.0 }\n";

fn rotary_values(text: &str, rest: &str) -> Findings {
    let cycle = cycle(text);
    let run = measure(&truth("table-bc", 8, &cycle, &[], rest), &cycle);
    by_method("rotary-values", &run, Convention::RightHanded).unwrap_or_else(|error| panic!("{error}"))
}

fn near(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found - expected).abs() <= within, "{what}: {found:e}, put in {expected:e}");
}

#[test]
fn repeating_motions_are_synchronous() {
    let found = rotary_values(
        &cycle_text("rotary-values-c"),
        &format!("[location]\nEX0C_um = 9.0\n{}{MOTIONS}", noise(0.0, 0.0)),
    );
    near(value(&found, "low.radial-x.synchronous"), 2.0 * UM, 0.02 * UM, "radial X");
    near(value(&found, "low.axial.synchronous"), 0.8 * UM, 0.02 * UM, "axial");
    near(value(&found, "tilt-a.synchronous"), 8.0 * URAD, 0.2 * URAD, "tilt about X");
    near(value(&found, "tilt-b.total"), 0.0, 0.1 * URAD, "no tilt about Y");
    for name in ["low.radial-x", "high.radial-y", "low.axial", "tilt-a"] {
        near(value(&found, &format!("{name}.asynchronous")), 0.0, 0.01 * UM, name);
        near(value(&found, &format!("{name}.reversal")), 0.0, 0.01 * UM, name);
        let total = value(&found, &format!("{name}.total"));
        near(total, value(&found, &format!("{name}.synchronous")), 0.01 * UM, name);
    }
}

#[test]
fn the_rotating_direction_mixes_both() {
    let radial: String =
        MOTIONS.split("[[hidden]]").nth(1).map(|one| format!("[[hidden]]{one}")).expect("the radial motion");
    let found =
        rotary_values(&cycle_text("rotary-values-c"), &format!("[location]\n{}{radial}", noise(0.0, 0.0)));
    // cos 3θ cos θ + ½ sin 3θ sin θ = ¾ cos 2θ + ¼ cos 4θ = ½c² + ¾c − ¼ with c = cos 2θ: largest 1 at c = 1, least −17/32 at c = −¾.
    near(value(&found, "low.radial-rotating.total"), (1.0 + 17.0 / 32.0) * UM, 0.02 * UM, "rotating");
}

#[test]
fn noise_is_asynchronous_and_the_mean_keeps_what_repeats() {
    let quiet =
        rotary_values(&cycle_text("rotary-values-c"), &format!("[location]\n{}{MOTIONS}", noise(0.0, 0.0)));
    let noisy =
        rotary_values(&cycle_text("rotary-values-c"), &format!("[location]\n{}{MOTIONS}", noise(0.1, 0.0)));
    let v = |findings: &Findings, name: &str| value(findings, &format!("low.radial-x.{name}"));
    // Range of three normal numbers at 120 stations: between 3 and 6 σ at the widest.
    assert!((0.3 * UM..0.7 * UM).contains(&v(&noisy, "asynchronous")), "{}", v(&noisy, "asynchronous"));
    near(v(&noisy, "synchronous"), v(&quiet, "synchronous"), 0.35 * UM, "synchronous");
    assert!(v(&noisy, "total") > v(&noisy, "synchronous"));
}

#[test]
fn one_turn_gives_the_total_alone_and_one_height_no_tilt() {
    let one_turn = cycle_text("rotary-values-c")
        .replace("from_deg = -540", "from_deg = -180")
        .replace("to_deg = 540", "to_deg = 180");
    let found = rotary_values(&one_turn, &format!("[location]\n{}{MOTIONS}", noise(0.0, 0.0)));
    near(value(&found, "low.radial-x.total"), 2.0 * UM, 0.02 * UM, "total");
    assert!(found.value("low.radial-x.synchronous").is_none());
    assert!(found.notes.iter().any(|note| note.contains("single turn")), "{:?}", found.notes);
    let one_height = cycle_text("rotary-values-c").replace("146.8", "66.7");
    let found = rotary_values(&one_height, &format!("[location]\n{}{MOTIONS}", noise(0.0, 0.0)));
    assert!(found.value("tilt-a.total").is_none());
    assert!(found.notes.iter().any(|note| note.contains("second height")), "{:?}", found.notes);
}
