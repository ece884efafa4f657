//! Several runs of `two-height`: what differs between them is not averaged without a word.

use crate::empty_runs::empty;
use nalgebra::Vector3;
use trunnion_core::Twist;
use trunnion_core::axis::iso::C;
use trunnion_cycles::Run;
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Site};
use trunnion_methods::Findings;
use trunnion_methods::findings::Cell;
use trunnion_methods::recipes::{self, MethodOptions};

const URAD: f64 = 1e-6;

/// A run at rest, C leaning by so much about Y.
fn leaning(eb0c: f64, seed: u64) -> Run {
    let mut run = empty("two-height-c-static", seed);
    let mut errors = Errors::default();
    errors.add(Site::Joint(C), Twist { rotation_rad: Vector3::new(0.0, eb0c, 0.0), ..Twist::default() });
    for point in &mut run.points {
        let setup = &run.setups[point.state.setup];
        let read = |errors: &Errors| predict(&run.machine, setup, &point.state, errors);
        let moved = read(&errors) - read(&Errors::default());
        (0..3).for_each(|k| point.reading_mm[k] += moved[k]);
    }
    run
}

fn found(runs: &[Run]) -> Findings {
    let method = recipes::find("two-height").unwrap();
    method.apply(runs, &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn runs_that_disagree_stand_in_a_table_and_are_doubted() {
    let tilts = [-30.0, -205.0, -379.0, -554.0].map(|urad| urad * URAD);
    let runs: Vec<Run> = tilts.iter().zip(1..).map(|(&tilt, seed)| leaning(tilt, seed)).collect();
    let together = found(&runs);
    assert!(
        together.notes[0].contains("The runs disagree") && together.notes[0].contains("EB0C from"),
        "{:?}",
        together.notes
    );
    // What else the runs hold agrees.
    assert!(!together.notes[0].contains("EA0C"), "{}", together.notes[0]);
    let of_each = &together.tables[0];
    assert_eq!(of_each.rows.len(), tilts.len());
    let place = |name: &str| of_each.columns.iter().position(|column| column.name == name).unwrap();
    for (row, tilt) in of_each.rows.iter().zip(tilts) {
        let number = |name: &str| match row[place(name)] {
            Cell::Number(number) => number,
            ref other => panic!("{other:?}"),
        };
        let (value, u) = (number("EB0C"), number("u of EB0C"));
        assert!((value - tilt).abs() < 4.5 * u && u < 5.0 * URAD, "{value:e} ± {u:e}, put in {tilt:e}");
    }
    // 226 µrad from run to run, over the root of four.
    let pooled = together.value("EB0C").unwrap();
    assert!((pooled.u.unwrap() / URAD - 113.0).abs() < 3.0, "{pooled:?}");
    assert!(together.charts[0].group.contains("without setting"), "{:?}", together.charts[0]);
}

#[test]
fn runs_of_one_machine_are_doubted_no_more_than_once_in_twenty() {
    let doubted = |seed: u64| {
        let runs: Vec<Run> = (0..3).map(|k| leaning(50.0 * URAD, 3 * seed + k)).collect();
        let together = found(&runs);
        assert_eq!(together.tables[0].rows.len(), 3);
        together.notes[0].contains("disagree")
    };
    // Sixty answers: 5 % and three standard deviations of a binomial.
    let count = (0..60).filter(|&seed| doubted(seed)).count();
    assert!(count <= 8, "{count}");
}

/// The first half of what was read at each height.
fn half(cycle: &str, seed: u64) -> Run {
    let mut run = empty(cycle, seed);
    let of = |setup: usize| run.points.iter().filter(|point| point.state.setup == setup).count();
    let most: Vec<usize> = (0..run.setups.len()).map(|setup| of(setup) / 2).collect();
    let mut kept = vec![0; most.len()];
    run.points.retain(|point| {
        let setup = point.state.setup;
        kept[setup] += 1;
        kept[setup] <= most[setup]
    });
    run
}

/// Of 400 numbers, how many ± 1.96 u hold.
fn held(runs: impl Fn(u64) -> Vec<Run>) -> usize {
    let inside = |seed: u64| {
        let found = found(&runs(seed));
        let holds = |name: &&str| {
            let value = found.value(name).unwrap();
            value.value.abs() <= 1.96 * value.u.unwrap()
        };
        ["EX0C", "EY0C", "EA0C", "EB0C"].into_iter().filter(holds).count()
    };
    (1000..1100).map(inside).sum()
}

/// Place and lean of a line go together, so of 400 numbers some 200 are independent: 95 % less two standard deviations of a binomial.
const FEWEST_HELD: usize = 368;

#[test]
fn intervals_of_one_run_hold_what_they_say() {
    let held = held(|seed| vec![empty("two-height-c-static", seed)]);
    assert!(held >= FEWEST_HELD, "{held} of 400");
}

/// At rest and on the fly together, the scatter of the passes alone says u: four at each height leave it some five degrees of freedom, of which
/// ± 1.96 u would hold 89 %.
#[test]
fn intervals_by_few_passes_hold_what_they_say() {
    let held = held(|seed| vec![half("two-height-c-static", seed), half("two-height-c", seed + 100)]);
    assert!(held >= FEWEST_HELD, "{held} of 400");
}
