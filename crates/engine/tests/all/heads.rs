//! Heads whose lines lie some millimetres apart: a shift of a line is an error of micrometres, and comes out as one.

use crate::common;
use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::{B, C};
use trunnion_core::{AxisValues, InstrumentKind, NestSide, Setup, State, Twist};
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, JointErrors, Machine};

const SEEDS: u64 = 24;
const NOISE_MM: f64 = 0.3e-3;
/// Errors of a machine as they are: 10 µm and 10 µrad, and no more than five times as much.
const USUAL: f64 = 10e-3;
const MOST: f64 = 5.0;

/// C carries B, which leans by `lean_deg` from Y towards Z; lines off each other by up to 5 mm in every direction.
fn head(lean_deg: f64, rng: &mut ChaCha8Rng) -> Machine {
    let mut off = || {
        let mm: [f64; 3] = std::array::from_fn(|_| rng.random_range(-5.0..5.0));
        format!("{mm:?}")
    };
    let (y, z) = (lean_deg.to_radians().cos(), lean_deg.to_radians().sin());
    let linear: String = [("X", [1, 0, 0]), ("Y", [0, 1, 0]), ("Z", [0, 0, 1])]
        .map(|(name, axis)| {
            format!(
                "[axis.{name}]\nkind = \"linear\"\ndirection = {axis:?}\nsense = 1\ntravel_mm = [-900, 900]\n"
            )
        })
        .concat();
    let rotary: String = [("C", [0.0, 0.0, 1.0]), ("B", [0.0, y, z])]
        .map(|(name, axis)| {
            let through = off();
            format!(
                "[axis.{name}]\nkind = \"rotary\"\ndirection = {axis:?}\nthrough_mm = {through}\nsense = 1\ntravel_deg = [-720, 720]\n"
            )
        })
        .concat();
    let text = format!(
        "format = \"trunnion-machine/1\"\ntable = [\"X\"]\ntool = [\"Y\", \"Z\", \"C\", \"B\"]\n{linear}{rotary}"
    );
    Machine::parse("head", "head.toml", &text).unwrap()
}

/// Two lengths of tool, 60 poses each, as exact kinematics reads them.
fn measured(machine: &Machine, errors: &Errors, rng: &mut ChaCha8Rng) -> Run {
    let setup = |name: &str, length_mm: f64| {
        let mut setup =
            Setup::new(name, InstrumentKind::RTest, NestSide::Table, Point3::new(140.0, 110.0, 60.0));
        setup.ball_in_tool_mm = Point3::new(0.0, 0.0, -length_mm);
        setup
    };
    let setups = vec![setup("short", 160.0), setup("long", 260.0)];
    let none = JointErrors::default();
    let mut points = Vec::new();
    for (k, placed) in setups.iter().enumerate() {
        for (b, c) in (-2..=2).flat_map(|b| (0..12).map(move |c| (b, c))) {
            let mut rotary = AxisValues::default();
            rotary[B] = f64::from(25 * b).to_radians();
            rotary[C] = f64::from(30 * c).to_radians();
            let turn = machine.machine_from_tool(&rotary, &none).rotation;
            let tip = placed.ball_in_table_mm - turn * placed.ball_in_tool_mm.coords;
            let position = machine.follow(&rotary, &tip).expect("within travel");
            let state = State { position, setup: k, ..State::default() };
            let noise: Vector3<f64> =
                Vector3::from_fn(|_, _| NOISE_MM * Distribution::<f64>::sample(&StandardNormal, rng));
            let reading = predict(machine, placed, &state, errors) + noise;
            points.push(common::point(state, reading.into()));
        }
    }
    common::run("head", machine.clone(), setups, points)
}

fn fitted(run: Run) -> Identification {
    let model = Model::base(&run.machine.name);
    identify(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap()
}

/// Where EY0B was zero by convention, 1 µm of it stood as a mrad and more in EC0C and EC0B: 20 mrad with an all-clear, or no convergence.
#[test]
fn a_shift_of_micrometres_is_no_turn_of_milliradians() {
    for seed in 0..SEEDS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let machine = head(if seed % 2 == 0 { 0.0 } else { 45.0 }, &mut rng);
        let mut errors = Errors::default();
        for axis in [C, B] {
            let mut of = || Vector3::from_fn(|_, _| USUAL * rng.random_range(-1.0..1.0));
            errors.joints[axis] = Twist::translation(of()) + Twist::rotation(of() * 1e-3);
        }
        let fit = fitted(measured(&machine, &errors, &mut rng));
        assert!(fit.rms_mm < 1.2 * NOISE_MM, "{seed}: {} mm", fit.rms_mm);
        let numbers = fit.parameters.iter().filter(|one| one.effect == "location-errors");
        for one in numbers {
            let size = one.screen_value().unwrap_or(0.0).abs();
            assert!(size < 1e3 * MOST * USUAL, "{seed}: {} = {size} {:?}", one.name, one.unit);
        }
    }
}
