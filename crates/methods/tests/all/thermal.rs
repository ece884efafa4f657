//! `thermal` on a machine of which one axis line moves away by a known curve.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::C;
use trunnion_core::{Point, Quality, Twist};
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::recipes::{self, MethodOptions};

const UM: f64 = 1e-3;
const TAU_S: f64 = 2400.0;
const FINAL_MM: f64 = 20.0 * UM;
const NOISE_MM: f64 = 0.3 * UM;

fn gone_mm(time_s: f64) -> f64 {
    FINAL_MM * (1.0 - (-time_s / TAU_S).exp())
}

/// The static R-test on a coarse grid, `count` times with a rest in between; EX0C goes away.
fn run(count: usize) -> Run {
    let path = format!("{}/../../config/cycles/r-test-static.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap().replace("step_deg = 30", "step_deg = 90");
    let text = format!("{text}\n[rounds]\ncount = {count}\nwait_s = 120\ninterleave = true\n");
    let cycle = Cycle::parse("cycle.toml", &text).unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let states = cycle.visits(&machine, &Pace::default()).unwrap().states;
    let point = |state: trunnion_core::State| {
        let mut errors = Errors::default();
        errors.joints[C] = Twist::translation(Vector3::x() * gone_mm(state.time_s.unwrap()));
        let read = predict(&machine, &cycle.setups[state.setup], &state, &errors);
        let reading_mm = [0, 1, 2].map(|k| read[k] + NOISE_MM * noise());
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points = states.into_iter().map(point).collect();
    let (name, setups) = ("warm".into(), cycle.setups.clone());
    Run { name, machine, kind: RunKind::Static, setups, channels: vec![], points }
}

#[test]
fn an_axis_line_that_goes_away_is_followed_with_its_time_constant() {
    let run = run(16);
    let found = recipes::find("thermal").unwrap().apply(&[run], &MethodOptions::default()).unwrap();
    let table = &found.tables[0];
    assert_eq!(table.rows.len(), 16);
    let column = |name: &str| table.columns.iter().position(|column| column.name == name).unwrap();
    let number = |row: usize, name: &str| match table.rows[row][column(name)] {
        trunnion_methods::findings::Cell::Number(number) => number,
        _ => panic!("{name} has no number in round {row}"),
    };
    for row in 0..16 {
        // The mean of the curve over a round is that at its mean time, but for its bend.
        let (value, u, expected) =
            (number(row, "EX0C"), number(row, "u(EX0C)"), gone_mm(number(row, "time")));
        assert!((value - expected).abs() < 4.5 * u + 0.1 * UM, "round {row}: {value} ± {u}, true {expected}");
    }
    let tau = found.value("EX0C time constant").unwrap();
    let off_u = (tau.value - TAU_S).abs() / tau.u.unwrap();
    assert!(off_u < 4.0, "{} ± {:?} s, true {TAU_S}", tau.value, tau.u);
    // What stays has no time constant worth the name.
    let still = found.value("EA0B change").unwrap();
    assert!(still.value.abs() < 4.5 * still.u.unwrap(), "{still:?}");
    assert!(found.charts.len() >= 2);
}

#[test]
fn a_cycle_that_was_run_once_is_sent_to_repeat_it() {
    let error = recipes::find("thermal").unwrap().apply(&[run(1)], &MethodOptions::default()).unwrap_err();
    assert!(error.to_string().contains("the poses are visited 1 times"), "{error}");
}
