//! Error motions of the tilting axis by the error map, over many seeds: noise is none, and what is there is found.

use crate::common::point;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::B;
use trunnion_core::{State, Twist};
use trunnion_cycles::{Cycle, Pace, Run, RunKind};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine, Site, shipped};
use trunnion_methods::findings::{FoundValue, ValueKind};
use trunnion_methods::recipes::MethodOptions;
use trunnion_methods::{Findings, recipes};

const NOISE_MM: f64 = 0.3e-3;
const SEEDS: u64 = 30;
/// Of 30 seeds, 5 % and 3 standard deviations of a binomial: 1.5 + 3 · 1.19.
const BY_CHANCE: usize = 5;

const NAMES: [&str; 6] = ["EXB", "EYB", "EZB", "EAB", "EBB", "ECB"];

/// The grid of S1, with B from −90° to 90° or all around, each pose read once.
struct Bench {
    machine: Machine,
    cycle: Cycle,
    states: Vec<State>,
}

impl Bench {
    fn new(range_of_b: &str) -> Self {
        let path = format!("{}/../../config/cycles/r-test-static.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.replace("passes = [\"+\", \"-\"]", "passes = [\"+\"]");
        let text = text.replace("from_deg = -90\nto_deg = 90", range_of_b);
        let cycle = Cycle::parse("cycle.toml", &text).unwrap_or_else(|problems| panic!("{problems}"));
        // A table that turns over as well as around.
        let (_, text) = shipped::FILES.iter().find(|(name, _)| *name == cycle.machine).unwrap();
        let text =
            text.replace("travel_deg = [-110, 110]", "travel_deg = [-180, 180]").replace("400]", "900]");
        let text = text.replace("[-400", "[-900");
        let machine = Machine::parse(&cycle.machine, "machine.toml", &text).unwrap();
        let states = cycle.visits(&machine, &Pace::default()).unwrap().states;
        Self { machine, cycle, states }
    }

    /// Half a turn and a whole one.
    fn both() -> [Self; 2] {
        ["from_deg = -90\nto_deg = 90", "from_deg = -180\nto_deg = 150"].map(Self::new)
    }

    /// The findings of a machine whose B shifts by this along X, mm; location errors of B and C stand in its readings too.
    fn findings(&self, shift_mm: impl Fn(f64) -> f64, noise_mm: f64, seed: u64) -> Findings {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut read = |state: &State| {
            let mut errors = Errors::default();
            let shift = Vector3::x() * shift_mm(state.position[B]);
            errors.add(Site::Joint(B), Twist::translation(shift));
            errors.add(Site::Joint(B), Twist::translation(Vector3::new(8e-3, 0.0, -6e-3)));
            errors.add(Site::Joint(B), Twist::rotation(Vector3::new(25e-6, 0.0, 18e-6)));
            let setup = &self.cycle.setups[state.setup];
            let exact = predict(&self.machine, setup, state, &errors);
            let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
            point(state.clone(), [0, 1, 2].map(|k| exact[k] + noise_mm * noise()))
        };
        let run = Run {
            name: self.cycle.name.clone(),
            machine: self.machine.clone(),
            kind: RunKind::Static,
            setups: self.cycle.setups.clone(),
            channels: vec![],
            points: self.states.iter().map(&mut read).collect(),
        };
        let method = recipes::find("error-map").expect("registered");
        method.apply(&[run], &MethodOptions::default()).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// What the map says of error motions with a standard uncertainty: location errors bear a zero in their name.
fn significant(findings: &Findings) -> Vec<&FoundValue> {
    let is_motion = |value: &&FoundValue| value.kind == ValueKind::Error && !value.name.contains('0');
    findings.values.iter().filter(is_motion).filter(|value| value.u.is_some()).collect()
}

fn of_b<'a>(findings: &'a Findings, name: &str) -> &'a FoundValue {
    let found = findings.values.iter().find(|value| value.name.starts_with(name));
    found.unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn noise_alone_is_a_significant_error_motion_as_seldom_as_promised() {
    for (bench, goes_around) in Bench::both().iter().zip([false, true]) {
        let all: Vec<Findings> = (0..SEEDS).map(|seed| bench.findings(|_| 0.0, NOISE_MM, seed)).collect();
        let false_alarms = all.iter().filter(|findings| !significant(findings).is_empty()).count();
        assert!(false_alarms <= BY_CHANCE, "{false_alarms} of {SEEDS}, all around: {goes_around}");
        let taken_for_more = |findings: &&Findings| {
            let notes = NAMES.iter().map(|name| &of_b(findings, name).note);
            notes.filter(|note| note.contains(", more than noise of the readings makes")).count() > 0
        };
        let named = all.iter().filter(taken_for_more).count();
        assert!(named <= BY_CHANCE, "{named} of {SEEDS}");
    }
}

#[test]
fn a_motion_of_two_waves_has_its_range_without_noise_or_an_upper_bound() {
    let motion = |tilt: f64| 1e-3 * (2.0 * tilt).cos();
    let [arc, around] = Bench::both();
    let true_range = |bench: &Bench| {
        let exact = bench.findings(motion, 0.0, 1);
        let value = of_b(&exact, "EXB range");
        (value.value, value.name.clone())
    };
    let (on_arc_mm, name) = true_range(&arc);
    assert_eq!(name, "EXB range at most");
    let mut held = 0;
    for seed in 0..SEEDS {
        let findings = arc.findings(motion, NOISE_MM, seed);
        let value = of_b(&findings, "EXB range at most");
        assert!(value.u.is_none() && value.note.contains(", more than noise"), "{value:?}");
        held += usize::from(value.value >= on_arc_mm);
    }
    assert!(held >= SEEDS as usize - BY_CHANCE, "{held} of {SEEDS}");
    let (range_mm, name) = true_range(&around);
    assert_eq!(name, "EXB range");
    let mut squares = 0.0;
    for seed in 0..SEEDS {
        let findings = around.findings(motion, NOISE_MM, seed);
        let value = of_b(&findings, "EXB range");
        let z = (value.value - range_mm) / value.u.expect("it is significant");
        squares += z * z / SEEDS as f64;
        assert!(z.abs() < 4.5, "{seed}: {value:?}, true {range_mm}");
    }
    // Each u has some five degrees of freedom, of which the root mean square of t is √(5/3).
    assert!((0.6..=1.6).contains(&squares.sqrt()), "{}", squares.sqrt());
}
