//! What comes back at the poses is no noise: an all-clear needs it to be smaller than what repeats differ by. Neither is what keeps still at a stop of
//! an axis and has moved at the next one.

use crate::common::points_run;
use nalgebra::{DMatrix, DVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_cycles::Run;
use trunnion_effects::{Instance, Model, Role};
use trunnion_engine::diagnosis::Options;
use trunnion_engine::solve::linear::least_squares;
use trunnion_engine::{Diagnosis, Experiment, Verdict, diagnose};

/// The run without a hidden effect (0.3 µm from reading to reading) with a smooth pattern over B and C that no effect and no expression is:
/// eight waves of one size for every probe.
fn with_pattern(wave_um: f64) -> Diagnosis {
    with_pattern_in_means(wave_um, 1.0)
}

/// The same, where each of its points is the mean of so many readings.
fn with_pattern_in_means(wave_um: f64, readings: f64) -> Diagnosis {
    let mut run = points_run("points-nothing-hidden");
    for point in &mut run.points {
        let (b, c) = (point.state.position[Joint::B], point.state.position[Joint::C]);
        for (k, reading_mm) in point.reading_mm.iter_mut().enumerate() {
            for m in 1..=8 {
                let (along_b, along_c) = (0.6 + 0.35 * f64::from(m), f64::from(m % 4 + 1));
                let phase = TAU * (0.618_033_988_749_895 * (8.0 * k as f64 + f64::from(m))).fract();
                *reading_mm += wave_um * 1e-3 * (along_b * b + along_c * c + phase).cos();
            }
        }
    }
    let model = Model::base(&run.machine.name);
    let experiment = Experiment::new(&[run]).unwrap().of_means(&[readings]);
    diagnose(&experiment, &model, &Options::default()).unwrap()
}

/// The residual is 1.6 times the repeatability: less than what wanders may be.
#[test]
fn a_pattern_that_is_larger_than_the_repeatability_gets_no_all_clear() {
    let found = with_pattern(0.225);
    let noise_um = found.residual.noise_um.expect("every pose was measured twice");
    assert!((found.residual.rms_um / noise_um - 1.6).abs() < 0.1, "{:?}", found.residual);
    assert_eq!(found.verdict, Verdict::UnnamedStructure, "{}", found.why);
    assert!(
        found.noise.pattern_um > noise_um && found.why.contains("comes back in repeats"),
        "{}",
        found.why
    );
    assert!(found.next_cycle.is_some());
}

/// Averaging makes the noise smaller, not the motions that every machine has.
#[test]
fn a_pattern_no_larger_than_the_noise_of_a_single_reading_is_no_finding_in_means_of_many() {
    let found = with_pattern_in_means(0.225, 20.0);
    let noise_um = found.residual.noise_um.expect("every pose was measured twice");
    assert!(found.noise.pattern_um > noise_um && found.noise.pattern_um < 20f64.sqrt() * noise_um);
    assert_ne!(found.verdict, Verdict::UnnamedStructure, "{}", found.why);
    let larger = with_pattern_in_means(1.2, 20.0);
    assert_eq!(larger.verdict, Verdict::UnnamedStructure, "{}", larger.why);
}

#[test]
fn a_smaller_pattern_is_natural_and_its_size_is_known() {
    let found = with_pattern(0.1);
    assert_eq!(found.verdict, Verdict::NoiseFloor, "{}", found.why);
    let noise_um = found.residual.noise_um.expect("every pose was measured twice");
    let pattern_um = found.noise.pattern_um;
    assert!(pattern_um < noise_um && (pattern_um - 0.2).abs() < 0.08, "put in 0.18 µm, found {pattern_um}");
}

/// A ball that sits at either of two places, 3 µm apart, drawn at random whenever the table tilts. Repeats differ by it too, so that no residual is larger
/// than they allow.
#[test]
fn a_seat_that_jumps_between_stops_gets_no_all_clear() {
    for seed in 1..=4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut run = points_run("points-nothing-hidden");
        let apart = Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)).normalize() * 3e-3;
        let (mut tilt, mut there) = (f64::NAN, false);
        for point in &mut run.points {
            let b = point.state.position[Joint::B];
            if b != tilt {
                (tilt, there) = (b, rng.random_bool(0.5));
            }
            if there {
                point.reading_mm.iter_mut().zip(apart.iter()).for_each(|(reading_mm, mm)| *reading_mm += mm);
            }
        }
        let model = Model::base(&run.machine.name);
        let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
        assert_eq!(found.verdict, Verdict::UnnamedStructure, "{seed}: {}", found.why);
        assert!(found.why.starts_with("From stop to stop of B the readings jump"), "{seed}: {}", found.why);
        // One component of a length that is there half of the time.
        let injected_um = 3.0 / 12f64.sqrt();
        assert!((found.noise.stations_um / injected_um - 1.0).abs() < 0.2, "{seed}: {:?}", found.noise);
    }
}

/// What an all-clear promises: an effect of the stated size, in whatever direction of its parameters, is noticed in nearly all cases.
#[test]
fn an_effect_of_the_stated_size_is_hardly_ever_passed_over() {
    let run = points_run("points-nothing-hidden");
    let model = Model::base(&run.machine.name);
    let diagnosed = |run: &Run| {
        let experiment = Experiment::new(std::slice::from_ref(run)).unwrap();
        diagnose(&experiment, &model, &Options::default()).unwrap()
    };
    let clear = diagnosed(&run);
    assert_eq!(clear.verdict, Verdict::NoiseFloor);
    let stated_mm = clear.noticeable_um.expect("an all-clear states it") / 1e3;

    let experiment = Experiment::new(std::slice::from_ref(&run)).unwrap();
    let columns = |instance: &Instance| experiment.columns(instance, &[]);
    let base: Vec<Instance> =
        model.effects.iter().map(|entry| Instance::from_model_effect(entry, &run.machine).unwrap()).collect();
    let base: Vec<_> = base
        .iter()
        .flat_map(|one| columns(one).column_iter().map(DVector::from).collect::<Vec<_>>())
        .collect();
    let base = DMatrix::from_columns(&base);
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let (mut passed_over, mut tried) = (Vec::new(), 0);
    for instance in Instance::all(&run.machine) {
        let parameters = instance.parameters(&experiment.scene).len();
        let is_usual = matches!(instance.role(), Role::Cause { .. } | Role::Natural);
        if !is_usual || parameters == 0 || !instance.shapes(&experiment.scene).names.is_empty() {
            continue;
        }
        let direction = DVector::from_fn(parameters, |_, _| StandardNormal.sample(&mut rng));
        let moved: DVector<f64> = columns(&instance) * direction;
        let left = &moved - &base * least_squares(&base, &moved, 1e-9).x;
        if left.norm() <= 0.1 * moved.norm() {
            // The model imitates it: no all-clear speaks of it.
            continue;
        }
        let moved = moved * (stated_mm * (left.len() as f64).sqrt() / left.norm());
        let mut with_it = run.clone();
        for (at, point) in with_it.points.iter_mut().enumerate() {
            let own = experiment.rows_of(at);
            point.reading_mm.iter_mut().zip(own).for_each(|(value, row)| *value += moved[row]);
        }
        tried += 1;
        if diagnosed(&with_it).verdict == Verdict::NoiseFloor {
            passed_over.push(instance.id());
        }
    }
    println!("{} of {tried} at {:.3} µm: {passed_over:?}", passed_over.len(), stated_mm * 1e3);
    // The size is promised for four of five effects in their worst direction; of a usual direction fewer than one in ten is left.
    assert!(tried >= 15 && 10 * passed_over.len() < tried, "{passed_over:?} of {tried}");
}
