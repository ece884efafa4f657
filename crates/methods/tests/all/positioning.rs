//! `positioning` on readings whose values are worked by hand.

use trunnion_core::axis::iso::X;
use trunnion_core::{Point, Quality, State};
use trunnion_cycles::{Cycle, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};
use trunnion_methods::recipes::{self, MethodError, MethodOptions};

const UM: f64 = 1e-3;

/// Approaches: position in mm, direction, deviation in µm.
fn run(approaches: &[(f64, f64, f64)]) -> Run {
    let path = format!("{}/../../config/cycles/linear-x.toml", env!("CARGO_MANIFEST_DIR"));
    let cycle = Cycle::parse("cycle.toml", &std::fs::read_to_string(path).unwrap())
        .unwrap_or_else(|problems| panic!("{problems}"));
    let machine = shipped::machine(&cycle.machine).unwrap();
    let point = |&(x_mm, direction, deviation_um): &(f64, f64, f64)| {
        let mut state = State::default();
        (state.position[X], state.direction[X]) = (x_mm, direction);
        // A display that was zeroed anywhere.
        let nominal_mm = predict(&machine, &cycle.setups[0], &state, &Errors::default()).x + 17.0;
        let reading_mm = [nominal_mm + deviation_um * UM, 0.0, 0.0];
        Point { reading_mm, state, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good }
    };
    let points = approaches.iter().map(point).collect();
    let setups = cycle.setups.clone();
    Run { name: "linear".into(), machine, kind: RunKind::Static, setups, channels: vec![], points }
}

#[test]
fn the_values_of_iso_230_2_are_those_worked_by_hand() {
    let run = run(&[
        (0.0, 1.0, 0.0),
        (100.0, 1.0, 10.0),
        (100.0, -1.0, 4.0),
        (0.0, -1.0, -4.0),
        (0.0, 1.0, 2.0),
        (100.0, 1.0, 12.0),
        (100.0, -1.0, 6.0),
        (0.0, -1.0, -2.0),
    ]);
    let found = recipes::find("positioning").unwrap().apply(&[run], &MethodOptions::default()).unwrap();
    // Means 1, 11 going up and −3, 5 going down, every s = √2.
    let root = 2.0_f64.sqrt();
    for (name, by_hand) in [
        ("B", 6.0),
        ("mean reversal", 5.0),
        ("R", 4.0 * root + 6.0),
        ("R↑", 4.0 * root),
        ("E", 14.0),
        ("E↑", 10.0),
        ("E↓", 8.0),
        ("M", 9.0),
        ("A", 14.0 + 4.0 * root),
        ("A↑", 10.0 + 4.0 * root),
    ] {
        let value = found.value(&format!("X {name}")).unwrap_or_else(|| panic!("no {name}"));
        assert!((value.value / UM - by_hand).abs() < 1e-9, "{name}: {}, by hand {by_hand}", value.value / UM);
    }
    // u(B) = √(s²/n + s²/n) = √2 for two approaches of s = √2.
    let u = found.value("X B").unwrap().u.unwrap();
    assert!((u / UM - root).abs() < 1e-9, "{u}");
}

/// The same readings in the values as in a fit: `identify` excludes a single wrong one.
#[test]
fn a_single_wrong_reading_counts_in_no_value_and_is_named() {
    let of = |wrong_um: f64| {
        let approach = |i: i32| {
            let k = i % 10;
            let x_mm = 100.0 * f64::from(if k < 5 { k } else { 9 - k });
            let noise_um = 0.3 * (f64::from(i) * 12.9898).sin();
            let wrong_um = if i == 37 { wrong_um } else { 0.0 };
            (x_mm, if k < 5 { 1.0 } else { -1.0 }, noise_um + wrong_um)
        };
        let approaches: Vec<(f64, f64, f64)> = (0..50).map(approach).collect();
        recipes::find("positioning").unwrap().apply(&[run(&approaches)], &MethodOptions::default()).unwrap()
    };
    let (good, wrong) = (of(0.0), of(30.0));
    assert_eq!((good.excluded, wrong.excluded), (0, 1));
    assert!(wrong.notes[0].contains("1 of 50 readings (row 38) lies far"), "{:?}", wrong.notes);
    let r_um = |of: &trunnion_methods::Findings| of.value("X R").unwrap().value / UM;
    assert!((r_um(&good) - r_um(&wrong)).abs() < 0.5, "{} and {}", r_um(&good), r_um(&wrong));
}

/// As a table without directions has them: of the last move, and none before the first.
fn without_directions(approaches: &[(f64, f64)]) -> Run {
    let rows: Vec<(f64, f64, f64)> = approaches.iter().map(|&(x_mm, um)| (x_mm, 0.0, um)).collect();
    let mut run = run(&rows);
    let mut travel = trunnion_core::direction::Travel::default();
    run.points.iter_mut().for_each(|point| travel.fill(&mut point.state, &[X]));
    run
}

#[test]
fn a_reading_without_a_move_before_it_takes_no_direction_from_the_one_before() {
    // Backlash of 3 µm; at both ends the second reading is one of the other side, and the table does not say so.
    let passes = [(0.0, -3.0), (50.0, -3.0), (100.0, -3.0), (100.0, 0.0), (50.0, 0.0), (0.0, 0.0)];
    let found = recipes::find("positioning")
        .unwrap()
        .apply(&[without_directions(&[passes, passes, passes].concat())], &MethodOptions::default())
        .unwrap();
    let um = |name: &str| found.value(&format!("X {name}")).unwrap().value / UM;
    assert!(um("R↑").abs() < 1e-9 && um("R↓").abs() < 1e-9, "{} {}", um("R↑"), um("R↓"));
    assert!((um("B") - 3.0).abs() < 1e-9);
    let notes = found.notes.join("\n");
    assert!(
        notes.contains("6 readings were left out, because the direction of their approach is not known"),
        "{notes}"
    );
    assert!(
        notes.contains("from one side alone: 0.0, 100.0 mm") && notes.contains("of the other 1 of 3"),
        "{notes}"
    );
    // Step by step: nothing of the second and later approaches is known.
    let step = |x_mm: f64| [(x_mm, -3.0), (x_mm, 0.0), (x_mm, -3.0), (x_mm, 0.0)];
    let run = without_directions(&[step(0.0), step(50.0), step(100.0)].concat());
    let error = recipes::find("positioning").unwrap().apply(&[run], &MethodOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("of 10 readings the direction is not known, state it (direction_x)"),
        "{error}"
    );
}

#[test]
fn a_single_pass_is_sent_to_repeat_its_approaches() {
    let run = run(&[(0.0, 1.0, 0.0), (100.0, 1.0, 1.0), (200.0, 1.0, 2.0)]);
    let error = recipes::find("positioning").unwrap().apply(&[run], &MethodOptions::default()).unwrap_err();
    assert!(
        matches!(error, MethodError::Lacks { .. }) && error.to_string().contains("twice or more"),
        "{error}"
    );
}
