//! Shares of the axes are of the cycle proper: run-in and run-out of a pass are not.

use trunnion_core::axis::iso::C;
use trunnion_core::{AxisSample, AxisValues};
use trunnion_cycles::Cycle;
use trunnion_machine::shipped;
use trunnion_methods::attribution::{Attribution, Motion, attribute};

/// From standing to the feed, s, at constant acceleration: the lead is then `feed · RAMP_S / 2` behind a constant feed.
const RAMP_S: f64 = 0.4;
const STEP_S: f64 = 0.008;
const DWELL_S: f64 = 0.4;

/// Time and angle of a pass with ramps at both ends.
fn swept(begin_s: f64, (from, to): (f64, f64), feed: f64) -> (f64, impl Fn(f64) -> f64) {
    let long_s = (to - from).abs() / feed + RAMP_S;
    let at = move |time_s: f64| {
        let t = (time_s - begin_s).clamp(0.0, long_s);
        let ramp = |t: f64| 0.5 * feed / RAMP_S * t * t;
        let gone = match () {
            () if t < RAMP_S => ramp(t),
            () if t > long_s - RAMP_S => (to - from).abs() - ramp(long_s - t),
            () => ramp(RAMP_S) + feed * (t - RAMP_S),
        };
        from + (to - from).signum() * gone
    };
    (begin_s + long_s, at)
}

/// The demo's sweep as the controller drives it: every pass speeds up and slows down inside its span. `beyond` is added to C.
fn attributed(beyond: impl Fn(f64) -> f64) -> Attribution {
    let machine = shipped::machine("table-bc").unwrap();
    let text = include_str!("../../../../config/cycles/demo-sweep-c.toml");
    let cycle = Cycle::parse("sweep.toml", text).unwrap();
    let (mut samples, mut begin_s) = (Vec::new(), 0.0);
    for sweep in cycle.sweeps() {
        let turn = std::f64::consts::TAU;
        let ends = if sweep.feed_rad_per_s > 0.0 { (0.0, turn) } else { (turn, 0.0) };
        let (end_s, at) = swept(begin_s, ends, sweep.feed_rad_per_s.abs());
        for k in 0.. {
            let time_s = begin_s + STEP_S * f64::from(k);
            if time_s > end_s + DWELL_S {
                break;
            }
            let mut rotary = AxisValues::default();
            rotary[C] = at(time_s);
            let mut position = cycle.position(&machine, 0, &rotary).unwrap();
            position[C] += beyond(time_s);
            samples.push(AxisSample { time_s, position, ..AxisSample::default() });
        }
        begin_s = end_s + DWELL_S;
    }
    let (machine, samples) = (&machine, &samples[..]);
    let motion = Motion { run: "sweep", machine, samples, cycle: Some(&cycle), commanded: None, knot_s: 1.0 };
    attribute(&motion).unwrap()
}

#[test]
fn run_in_and_run_out_are_no_share_of_an_axis_and_are_counted() {
    let found = attributed(|_| 0.0);
    assert_eq!(found.passes.len(), 4);
    let peak_um = |found: &Attribution| {
        found.shares.iter().map(|share| 1e3 * share.deviation.peak_mm()).fold(0.0, f64::max)
    };
    // A constant feed that is followed exactly leaves nothing; the ramps are 23 mm off it at 150 mm.
    assert!(peak_um(&found) < 0.1, "{}", peak_um(&found));
    // Two ramps in each of four passes; beyond them the windows of the rule, 0.1 s at each end.
    let ramps = 8.0 * RAMP_S / STEP_S;
    let counted = found.left_out.run_in_and_out as f64;
    assert!((0.7 * ramps..1.3 * ramps).contains(&counted), "{counted} of {ramps}");
    let judged = found.time_s.len() as f64;
    assert!(judged > 4.0 * 2.0 / STEP_S, "{judged}");
    let notes = found.to_findings().notes;
    assert!(notes.iter().any(|note| note.contains(&format!("{counted} of run-in and run-out"))), "{notes:?}");
}

#[test]
fn what_an_axis_does_at_the_feed_stays_its_share() {
    // 10 µrad over half a second in the middle of the first pass: 1.5 µm at 150 mm.
    let bump = |time_s: f64| if (1.9..2.4).contains(&time_s) { 1e-5 } else { 0.0 };
    let found = attributed(bump);
    let share = found.shares.iter().find(|share| share.axis == C).unwrap();
    let peak_um = 1e3 * share.deviation.peak_mm();
    // The line through the pass takes a part of it.
    assert!((1.1..1.6).contains(&peak_um), "{peak_um}");
}
