//! What comes back at the poses is no noise: an all-clear needs it to be smaller than what repeats differ by. Neither is what keeps still at a stop of
//! an axis and has moved at the next one.

use crate::common::points_run;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trunnion_core::Joint;
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
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
        let put_in_um = 3.0 / 12f64.sqrt();
        assert!((found.noise.stations_um / put_in_um - 1.0).abs() < 0.2, "{seed}: {:?}", found.noise);
    }
}
