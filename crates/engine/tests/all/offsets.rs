//! A work offset that was active, or a ball that is millimetres from where it is said to be: the fit comes to rest, the numbers that do not hold
//! the offset are as without it, and the one that does is doubted.

use crate::common;
use nalgebra::Point3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::{A, C};
use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Point, Setup, State};
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::fit::doubts::{DoubtReason, doubts};
use trunnion_engine::{Experiment, Identification, identify};
use trunnion_machine::shipped;

const WHITE_MM: f64 = 0.2e-3;

/// Two heights, A −90…0° and C 0…330°, there and back, of a machine without errors whose positions are all off by `offset_mm`.
fn measured(offset_mm: [f64; 3], seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let machine = shipped::machine("table-ac").expect("shipped");
    let setup = |name: &str, z: f64| {
        Setup::new(name, InstrumentKind::RTest, NestSide::Table, Point3::new(164.6, 0.0, z))
    };
    let setups = vec![setup("low", 71.3), setup("high", 184.5)];
    let there: Vec<(i32, i32)> = (-3..=0).flat_map(|a| (0..12).map(move |c| (a, c))).collect();
    let mut points: Vec<Point> = Vec::new();
    for (i, placed) in setups.iter().enumerate() {
        let back = there.iter().rev().map(|&pose| (pose, -1.0));
        for ((a, c), direction) in there.iter().map(|&pose| (pose, 1.0)).chain(back) {
            let mut rotary = AxisValues::default();
            rotary[A] = f64::from(30 * a).to_radians();
            rotary[C] = f64::from(30 * c).to_radians();
            let mut position = machine.follow(&rotary, &placed.ball_in_table_mm).expect("within travel");
            Joint::LINEAR.into_iter().zip(offset_mm).for_each(|(joint, off_mm)| position[joint] += off_mm);
            let time_s = Some(5.0 * points.len() as f64);
            let mut state = State { position, time_s, setup: i, ..State::default() };
            (state.direction[A], state.direction[C]) = (direction, direction);
            let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
            let reading_mm = [0.0; 3].map(|_: f64| WHITE_MM * white());
            points.push(common::point(state, reading_mm));
        }
    }
    common::run("offset", machine, setups, points)
}

fn fitted(offset_mm: [f64; 3], seed: u64) -> (Experiment, Identification) {
    let experiment = Experiment::new(&[measured(offset_mm, seed)]).expect("points");
    let fit = identify(&experiment, &Model::base("table-ac"), &Options::default());
    let fit = fit.unwrap_or_else(|error| panic!("{offset_mm:?}, seed {seed}: {error}"));
    (experiment, fit)
}

#[test]
fn a_fit_to_positions_that_are_all_off_comes_to_rest_and_the_offset_is_doubted() {
    for seed in 0..3 {
        let (_, without) = fitted([0.0; 3], seed);
        for (k, off_mm) in [(0, 1.2), (0, 3.2), (1, -3.0), (2, 1.2), (2, -3.0)] {
            let mut offset_mm = [0.0; 3];
            offset_mm[k] = off_mm;
            let (experiment, fit) = fitted(offset_mm, seed);
            assert!(
                (fit.rms_mm / without.rms_mm - 1.0).abs() < 0.01,
                "{offset_mm:?}, seed {seed}: {} mm",
                fit.rms_mm
            );
            let tilts = fit.parameters.iter().filter(|p| p.effect == "location-errors" && p.observable());
            for tilt in tilts.filter(|p| ["EA0A", "EB0A", "EB0C"].contains(&p.name.as_str())) {
                let (value, u) = (tilt.screen_value().unwrap(), tilt.screen_u().unwrap());
                assert!(
                    value.abs() < 4.5 * u,
                    "{offset_mm:?}, seed {seed}: {} = {value} ± {u} µrad",
                    tilt.name
                );
            }
            let model = Model::base("table-ac");
            let found = doubts(&experiment, &model, &fit);
            let of_place =
                found.iter().filter(|doubt| matches!(doubt.reason, DoubtReason::BeyondPhysical { .. }));
            assert!(of_place.count() > 0, "{offset_mm:?}, seed {seed}: {found:?}");
        }
    }
}
