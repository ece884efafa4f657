//! Axes never stop twice at the same micrometre, and displays round: a pose that is measured again is the same pose.

use crate::common::points_run;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::Joint;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::diagnosis::Options;
use trunnion_engine::{Diagnosis, Experiment, Verdict, diagnose};

const SEEDS: u64 = 4;

fn diagnosed(run: Run) -> Diagnosis {
    let model = Model::base(&run.machine.name);
    let experiment = Experiment::new(&[run]).unwrap();
    diagnose(&experiment, &model, &Options::default()).unwrap()
}

/// Linear axes stop off their place by 2 µm (one standard deviation), say so, and the probes see it.
fn stopped_elsewhere(mut run: Run, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for point in &mut run.points {
        let (sin_b, cos_b) = point.state.position[Joint::B].sin_cos();
        let (sin_c, cos_c) = point.state.position[Joint::C].sin_cos();
        let off_mm = Joint::LINEAR.map(|joint| {
            let off: f64 = StandardNormal.sample(&mut rng);
            point.state.position[joint] += 2e-3 * off;
            2e-3 * off
        });
        // Into table axes: back by B about Y, then by C about Z.
        let frame = [cos_b * off_mm[0] - sin_b * off_mm[2], off_mm[1], sin_b * off_mm[0] + cos_b * off_mm[2]];
        let table = [cos_c * frame[0] + sin_c * frame[1], -sin_c * frame[0] + cos_c * frame[1], frame[2]];
        (0..3).for_each(|k| point.reading_mm[k] += table[k]);
    }
    run
}

/// Positions as a display of 1 µm shows them.
fn rounded(mut run: Run) -> Run {
    for point in &mut run.points {
        for joint in Joint::LINEAR {
            let shown = &mut point.state.position[joint];
            *shown = (*shown * 1e3).round() / 1e3;
        }
    }
    run
}

/// Positions that flicker by 0.5 µm and 2 µrad while the probes see nothing of it.
fn flickering(mut run: Run, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for point in &mut run.points {
        for (joints, size) in [(&Joint::LINEAR[..], 0.5e-3), (&[Joint::B, Joint::C][..], 2e-6)] {
            for &joint in joints {
                let off: f64 = StandardNormal.sample(&mut rng);
                point.state.position[joint] += size * off;
            }
        }
    }
    run
}

#[test]
fn positions_that_scatter_leave_the_answer_as_it_is() {
    for seed in 0..SEEDS {
        let nothing = diagnosed(stopped_elsewhere(points_run("points-nothing-hidden"), seed));
        assert_eq!(nothing.verdict, Verdict::NoiseFloor, "{seed}: {}", nothing.why);
        let noise_um = nothing.residual.noise_um.expect("poses were measured twice");
        assert!((noise_um - 0.3).abs() < 0.05, "{seed}: repeatability {noise_um} µm, put in 0.3");
        let sag = diagnosed(stopped_elsewhere(points_run("points-gravity"), seed));
        assert_eq!(sag.candidates[0].effect, "gravity-sag:B", "{seed}");
        assert!(sag.candidates[0].adequate(), "{seed}");
    }
}

#[test]
fn positions_that_the_readings_do_not_follow_are_no_effect_and_hide_none() {
    let disturbed = |set: &str| {
        let flickering = (0..SEEDS).map(|seed| flickering(points_run(set), seed));
        std::iter::once(rounded(points_run(set))).chain(flickering).map(diagnosed).collect::<Vec<_>>()
    };
    for diagnosis in disturbed("points-nothing-hidden") {
        let quiet = [Verdict::NoiseFloor, Verdict::Undecided].contains(&diagnosis.verdict);
        assert!(quiet && diagnosis.candidates.is_empty(), "{:?} {:?}", diagnosis.verdict, diagnosis.set);
    }
    for diagnosis in disturbed("points-gravity") {
        assert_eq!(diagnosis.candidates[0].effect, "gravity-sag:B", "{}", diagnosis.why);
    }
}
