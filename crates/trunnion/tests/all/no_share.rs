//! Predictions of runs that an effect of the model is out of reach of: each is made or refused with what the run lacks.

use std::path::Path;
use trunnion::{Error, Experiment};
use trunnion_core::{Point, Quality, State};
use trunnion_cycles::{Cycle, Pace, Run};
use trunnion_effects::Instance;
use trunnion_machine::shipped;

/// A run of a cycle in which nothing but noise is read; of its points those that are kept.
fn run(folder: &Path, name: &str, cycle: &str, kept: impl Fn(usize, &State) -> bool) -> Experiment {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let text = |path: String| std::fs::read_to_string(root.join(path)).unwrap();
    let cycle = Cycle::parse(cycle, &text(format!("cycles/{cycle}.toml"))).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let pace = Pace { points_per_s: 2.0, ..Pace::default() };
    let states = cycle.visits(&machine, &pace).unwrap().states;
    let noise_mm = |k: usize| ((12.9898 * k as f64).sin() * 43_758.545_3).fract() * 1e-3;
    let point = |(k, state): (usize, State)| Point {
        reading_mm: [0, 1, 2].map(|component| noise_mm(3 * k + component)),
        state,
        spread_mm: [0.0; 3],
        samples: 0,
        quality: Quality::Good,
    };
    let points = states.into_iter().enumerate().filter(|(k, state)| kept(*k, state)).map(point).collect();
    let (kind, setups) = (cycle.run_kind(), cycle.setups.clone());
    let run = Run { name: name.into(), machine, kind, setups, channels: Vec::new(), points };
    let file = folder.join(format!("{name}.mcap"));
    trunnion::tables::record(&file, &run, &text(format!("machines/{}.toml", cycle.machine)), "", &[])
        .unwrap();
    trunnion::open(file).unwrap()
}

/// Every effect of the catalogue that one of the runs can show, in each of the others. A third of the poses serves.
#[test]
fn every_effect_is_predicted_or_refused_with_what_the_run_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let with =
        |name: &str, cycle: &str, kept: fn(usize, &State) -> bool| run(folder.path(), name, cycle, kept);
    let runs = [
        with("static", "r-test-static", |k, _| k % 3 == 0),
        with("b-rests", "r-test-static", |_, state| state.position[trunnion_core::Joint::B] == 0.0),
        with("one-way", "r-test-static", |k, state| {
            k % 3 == 0 && state.direction[trunnion_core::Joint::C] > 0.0
        }),
        with("sweep-b", "r-test-sweep-b", |_, _| true),
        with("sweep-c", "r-test-sweep-c", |_, _| true),
    ];
    let (mut predicted, mut refused) = (0, Vec::new());
    for (k, fitted) in runs.iter().enumerate() {
        let base = fitted.fit(&fitted.base_model()).unwrap();
        for instance in Instance::all(fitted.machine()) {
            let id = instance.id();
            let Ok(fit) = base.add(&id) else { continue };
            for other in runs.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, other)| other) {
                match fit.predict(other) {
                    Ok(prediction) => {
                        predicted += 1;
                        assert!(prediction.runs[0].rms_um.is_finite(), "{id}");
                    }
                    Err(error @ (Error::NoShare { .. } | Error::Lacks { .. })) => {
                        refused.push(error.to_string())
                    }
                    Err(error) => panic!("{id}: {}", trunnion::chain(&error)),
                }
            }
        }
    }
    println!("{predicted} predicted, {} refused", refused.len());
    assert!(predicted > 200 && refused.len() > 50, "{predicted} predicted, {} refused", refused.len());
    let is_refused = |run: &str, effect: &str| {
        refused.iter().any(|why| why.starts_with(run) && why.contains(effect) && why.contains("needs"))
    };
    assert!(is_refused("b-rests", "gravity-sag:B"), "{refused:#?}");
    assert!(is_refused("sweep-c", "stacked-tilt:C"), "{refused:#?}");
    // At rest an axis that lags stands where it was sent.
    assert!(!is_refused("static", "servo-lag:C"), "{refused:#?}");
}
