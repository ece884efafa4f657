//! `quasi-static` on machines whose errors have known parts.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::{B, C, X};
use trunnion_core::{Point, Quality, State, Twist};
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::Findings;
use trunnion_methods::findings::{Cell, ValueKind};
use trunnion_methods::recipes::{self, MethodError, MethodOptions};

const UM: f64 = 1e-3;
const NOISE_MM: f64 = 0.3 * UM;
/// From sweep to sweep.
const OFFSET_MM: f64 = 0.1 * UM;
const SEEDS: u64 = 30;
/// µm at the fastest feed.
const PARTS: [(&str, f64); 4] = [
    ("quasi-static part", 8.0),
    ("part with the direction", -0.7),
    ("part with speed", 3.0),
    ("part with acceleration", -2.0),
];

fn cycle(name: &str, change: (&str, &str)) -> Cycle {
    let path = format!("{}/../../config/cycles/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(change.0), "{name}: {}", change.0);
    Cycle::parse("cycle.toml", &text.replace(change.0, change.1))
        .unwrap_or_else(|problems| panic!("{problems}"))
}

/// The cycle on a machine with these errors; the noise has an offset for each sweep.
fn measured(cycle: &Cycle, seed: u64, errors: impl Fn(&State) -> Errors) -> Run {
    let machine = shipped::machine(&cycle.machine).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let (mut offset_mm, mut before) = ([0.0; 3], 0.0);
    let mut point = |state: State| {
        let velocity = if state.velocity[C] != 0.0 { state.velocity[C] } else { state.velocity[X] };
        if velocity.signum() != before {
            offset_mm = [(); 3].map(|()| OFFSET_MM * noise());
            before = velocity.signum();
        }
        let read = predict(&machine, &cycle.setups[state.setup], &state, &errors(&state));
        let reading_mm = [0, 1, 2].map(|k| read[k] + offset_mm[k] + NOISE_MM * noise());
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points =
        cycle.visits(&machine, &Pace::default()).unwrap().states.into_iter().map(&mut point).collect();
    let (name, setups) = (cycle.name.clone(), cycle.setups.clone());
    Run { name, machine: machine.clone(), kind: RunKind::OnTheFly, setups, channels: vec![], points }
}

fn split(runs: &[Run]) -> Result<Findings, MethodError> {
    split_by(runs, MethodOptions::default())
}

fn split_by(runs: &[Run], options: MethodOptions) -> Result<Findings, MethodError> {
    recipes::find("quasi-static").unwrap().apply(runs, &options)
}

/// C goes along X by known parts; the fastest feed is 7200 °/min.
fn of_c(state: &State) -> Errors {
    let feed = state.velocity[C].abs().to_degrees() * 60.0 / 7200.0;
    let way = state.velocity[C].signum();
    let [q, r, s, a] = PARTS.map(|(_, um)| um * UM);
    let mut errors = Errors::default();
    errors.joints[C] = Twist::translation(Vector3::x() * (q + r * way + s * way * feed + a * feed * feed));
    errors
}

#[test]
fn every_part_of_an_error_is_found_within_its_uncertainty() {
    let cycle = cycle("r-test-feeds-c", ("", ""));
    let mut squares = 0.0;
    for seed in 0..SEEDS {
        let found = split(&[measured(&cycle, seed, of_c)]).unwrap();
        for (name, of_x) in PARTS {
            for (error, expected) in [("EX0C", of_x * UM), ("EY0C", 0.0)] {
                let value = found.value(&format!("{error} {name}")).unwrap();
                let z = (value.value - expected) / value.u.unwrap();
                assert!(z.abs() < 4.5, "seed {seed}: {value:?}, true {expected}");
                squares += z * z;
            }
        }
    }
    // Eight degrees of freedom: u by Student's t makes rms z 0.98.
    let rms = (squares / (8 * SEEDS) as f64).sqrt();
    assert!((0.8..=1.2).contains(&rms), "rms z {rms}");
}

#[test]
fn a_lag_of_one_axis_is_the_part_of_squareness_that_grows_with_speed() {
    // e_x = −T v_x on a circle of radius R at feed F: x = R cos φ, so e_x = T F/R y, which is a squareness EC0Y = −T F/R.
    let cycle = cycle("circle-xy", ("feeds_mm_per_min = [1000]", "feeds_mm_per_min = [1000, 2000, 4000]"));
    let lag_s = 0.1e-3;
    let run = measured(&cycle, 1, |state| {
        let mut errors = Errors::default();
        errors.joints[X] = Twist::translation(Vector3::x() * (-lag_s * state.velocity[X]));
        errors
    });
    let found = split(&[run]).unwrap();
    let near = |name: &str, expected: f64| {
        let value = found.value(name).unwrap();
        assert!(
            (value.value - expected).abs() < 4.5 * value.u.unwrap() + 0.2e-6,
            "{value:?}, true {expected}"
        );
    };
    near("EC0Y part with speed", -lag_s * (4000.0 / 60.0) / 150.0);
    near("EC0Y quasi-static part", 0.0);
    near("EC0Y part with acceleration", 0.0);
}

#[test]
fn runs_of_one_feed_each_are_split_together() {
    let feeds = ["[1800]", "[3600]", "[7200]"];
    let run = |(k, feeds): (usize, &str)| {
        measured(&cycle("r-test-feeds-c", ("[1800, 3600, 7200]", feeds)), k as u64, of_c)
    };
    let runs: Vec<Run> = feeds.into_iter().enumerate().map(run).collect();
    let found = split(&runs).unwrap();
    let value = found.value("EX0C part with speed").unwrap();
    assert!((value.value - 3.0 * UM).abs() < 4.5 * value.u.unwrap(), "{value:?}");
    // The ball may have been mounted again.
    assert!(found.values.iter().all(|value| !value.name.starts_with("ball-setting")));
}

#[test]
fn too_few_feeds_or_sweeps_are_sent_to_measure_more() {
    let refused = |feeds: &str, rounds: &str| {
        let path = format!("{}/../../config/cycles/r-test-feeds-c.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.replace("[1800, 3600, 7200]", feeds).replace("count = 2", rounds);
        let cycle = Cycle::parse("cycle.toml", &text).unwrap_or_else(|problems| panic!("{problems}"));
        split(&[measured(&cycle, 0, of_c)]).unwrap_err().to_string()
    };
    let one = refused("[3600]", "count = 2");
    assert!(one.contains("one feed") && one.contains("second feed"), "{one}");
    let two = refused("[1800, 3600]", "count = 1");
    assert!(two.contains("no degree of freedom") && two.contains("third feed"), "{two}");
}

/// What stays where the machine was not moved, C alone shifted.
fn still(_: &State) -> Errors {
    let mut errors = Errors::default();
    errors.joints[C] = Twist::translation(Vector3::x() * (8.0 * UM));
    errors
}

#[test]
fn errors_that_do_not_depend_on_the_feed_are_seldom_said_to() {
    let cycle = cycle("r-test-feeds-c", ("", ""));
    let is_alarmed = |seed: &u64| {
        let found = split(&[measured(&cycle, *seed, still)]).unwrap();
        let note = &found.notes[0];
        assert!(
            note.contains("(5 % for all of them together): ") != note.starts_with("No error depends"),
            "{note}"
        );
        !note.starts_with("No error depends")
    };
    let alarms = (0..SEEDS).filter(is_alarmed).count();
    // 5 % of 30; six or more come by chance once in 300.
    assert!(alarms <= 5, "{alarms} of {SEEDS}");
}

#[test]
fn what_mounting_left_is_no_error_of_the_machine_unless_it_grows_with_the_feed() {
    let cycle = cycle("r-test-feeds-c", ("", ""));
    let found = split(&[measured(&cycle, 3, of_c)]).unwrap();
    let kind = |name: &str| found.value(name).unwrap_or_else(|| panic!("no {name}")).kind;
    assert_eq!(kind("ball-setting.low.y quasi-static part"), ValueKind::Setting);
    assert_eq!(kind("ball-setting.low.y part with speed"), ValueKind::Error);
    assert_eq!(kind("EX0C quasi-static part"), ValueKind::Error);
}

#[test]
fn a_fast_feed_of_few_readings_is_a_feed() {
    // 10 readings a second: 1080 of a turn at 200 °/min, 30 at 7200 °/min.
    let cycle = cycle("r-test-feeds-c", ("[1800, 3600, 7200]", "[200, 7200]"));
    let found = split(&[measured(&cycle, 1, of_c)]).unwrap_or_else(|error| panic!("{error}"));
    let table = found.tables.iter().find(|table| table.caption.contains("at each feed")).unwrap();
    let feeds: Vec<f64> = table
        .rows
        .iter()
        .map(|row| match row[0] {
            Cell::Number(feed) => (feed * table.columns[0].unit.unwrap().per_inside).round(),
            _ => f64::NAN,
        })
        .collect();
    assert_eq!(feeds, [200.0, 7200.0]);
}

#[test]
fn an_axis_that_did_not_turn_is_refused() {
    let run = measured(&cycle("r-test-feeds-c", ("", "")), 1, of_c);
    let asked = |axis| {
        split_by(std::slice::from_ref(&run), MethodOptions { axis: Some(axis), ..MethodOptions::default() })
    };
    assert!(asked(C).is_ok());
    let refused = asked(B).unwrap_err().to_string();
    assert!(refused.contains("axis B") && refused.contains("C turns"), "{refused}");
}
