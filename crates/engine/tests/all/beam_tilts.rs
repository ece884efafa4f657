//! The tilt of a laser beam, which no reading shows to first order, is in the uncertainties of what its square and its product with the
//! tilt of the mirror move.

use crate::common;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::State;
use trunnion_cycles::{Cycle, Pace};
use trunnion_effects::{Model, Prior};
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, HeldOut, Identification, Uncertainties, identify};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, shipped};

const CYCLE: &str = include_str!("../../../../config/cycles/step-diagonal.toml");
const MODEL: &str = include_str!("../../../../config/models/straight-lines.toml");
/// Small against what the tilts make, 0.2 µrad.
const WHITE_MM: f64 = 0.05e-3;
const TILT_RAD: f64 = 0.3e-3;
const DRAWS: u64 = 60;
/// 180 numbers, three of each draw alike: rms z of a right u is 1 ± 0.09.
const RMS_Z: std::ops::RangeInclusive<f64> = 0.8..=1.2;

/// What the model says of the beams.
#[derive(Clone, Copy)]
enum Beams {
    Unknown,
    /// Held at zero.
    Known,
    /// A prior of this u, µrad.
    Within(f64),
}

/// A perfect machine measured along four diagonals, its mirrors and beams tilted.
fn fitted(seed: u64, tilt_rad: f64, beams: Beams) -> Identification {
    let cycle = Cycle::parse("step-diagonal.toml", CYCLE).unwrap();
    let machine = shipped::machine("three-axis").unwrap();
    let visits = cycle.visits(&machine, &Pace::default()).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut mounted = Vec::new();
    for _ in &cycle.setups {
        let mut errors = Errors::default();
        errors.instrument[..4].iter_mut().for_each(|tilt| *tilt = tilt_rad * normal());
        mounted.push(errors);
    }
    let mut read = |state: State| {
        let reading = predict(&machine, &cycle.setups[state.setup], &state, &mounted[state.setup]);
        common::point(state, [reading.x + WHITE_MM * normal(), 0.0, 0.0])
    };
    let points = visits.states.into_iter().map(&mut read).collect();
    let run = common::run("tilted", machine.clone(), cycle.setups.clone(), points);
    let mut model = Model::parse("straight-lines.toml", MODEL).unwrap();
    let setting = model.effects.iter_mut().find(|effect| effect.id == "ball-setting").unwrap();
    for setup in &cycle.setups {
        for beam in ["beam-1", "beam-2"] {
            let name = format!("ball-setting.{}.{beam}", setup.name);
            match beams {
                Beams::Unknown => {}
                Beams::Known => setting.fixed.push((name, 0.0)),
                Beams::Within(u) => setting.prior.push((name, Prior { value: 0.0, u })),
            }
        }
    }
    let options =
        Options { holdout: HeldOut::Skipped, uncertainties: Uncertainties::Clusters, ..Options::default() };
    identify(&Experiment::new(&[run]).unwrap(), &model, &options).unwrap()
}

const SQUARE: [&str; 3] = ["EC0Y", "EB0Z", "EA0Z"];

fn rms_z(beams: Beams) -> f64 {
    let squares = (0..DRAWS).flat_map(|seed| {
        let fit = fitted(seed, TILT_RAD, beams);
        SQUARE.map(|name| {
            let number = fit.parameter(name).unwrap();
            (number.value.unwrap() / number.u.unwrap()).powi(2)
        })
    });
    (squares.sum::<f64>() / (3 * DRAWS) as f64).sqrt()
}

#[test]
fn u_of_squareness_by_step_diagonals_holds_the_tilts_of_the_beams() {
    let rms = rms_z(Beams::Unknown);
    assert!(RMS_Z.contains(&rms), "rms z {rms}");
}

#[test]
fn without_the_tilts_of_the_beams_u_would_be_far_too_small() {
    let rms = rms_z(Beams::Known);
    assert!(rms > 2.0, "rms z {rms} with beams that are taken as known");
}

#[test]
fn a_beam_before_a_mirror_that_leans_scales_its_line() {
    // The scale of one diagonal errs by σ √(m² + σ²), and a squareness is 3/4 of ± four of them; the squares have the same mean on all
    // diagonals, which cancels.
    let without = fitted(1, 0.0, Beams::Known);
    // What the beam is known within, rad: the instrument's word, and a better one of the model.
    for (beams, sigma) in [(Beams::Unknown, 0.5e-3 / 3.0_f64.sqrt()), (Beams::Within(200.0), 0.2e-3)] {
        let with = fitted(1, 0.0, beams);
        for name in SQUARE {
            let u = |fit: &Identification| fit.parameter(name).unwrap().u.unwrap();
            let expected = 0.75 * 2.0 * sigma * sigma;
            let of_tilts = (u(&with).powi(2) - u(&without).powi(2)).sqrt();
            assert!((of_tilts / expected - 1.0).abs() < 0.02, "{name}: {of_tilts} of {expected}");
        }
    }
}
