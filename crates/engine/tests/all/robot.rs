//! A robot of six rotary joints: location errors of its joints from lengths to four tracking interferometers.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{AxisValues, InstrumentKind, NestSide, Point, Quality, Setup, State, Twist};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::{Experiment, Identification, identify};
use trunnion_instruments::predict;
use trunnion_machine::{Errors, Machine};

/// Where the stations stand, mm.
const STATIONS_MM: [[f64; 3]; 4] = [
    [-2500.0, -1500.0, 300.0],
    [2000.0, -1800.0, 1200.0],
    [300.0, 2400.0, -600.0],
    [-1800.0, 1900.0, 1700.0],
];
/// Reflectors on the flange, from its centre, mm: three places show how the flange turns.
const REFLECTORS_MM: [[f64; 3]; 3] = [[80.0, -60.0, 0.0], [-70.0, -40.0, 60.0], [0.0, -90.0, -80.0]];
const FLANGE_MM: [f64; 3] = [-817.25, -191.45, -5.491];
const POSES: usize = 40;
/// Noise of a length, mm.
const NOISE_MM: f64 = 0.5e-3;

fn robot() -> Machine {
    let text = include_str!("../../../../config/robots/ur5.toml");
    Machine::parse("robot", "robot.toml", text).unwrap()
}

fn setups() -> Vec<Setup> {
    let at = |k: usize, reflector_mm: [f64; 3]| {
        let mut setup = Setup::new(
            format!("station {k}, reflector {}", reflector_mm[0]),
            InstrumentKind::Tracker,
            NestSide::Table,
            Point3::from(STATIONS_MM[k]),
        );
        setup.ball_in_tool_mm = Point3::from(FLANGE_MM) + Vector3::from(reflector_mm);
        setup.bar_length_mm = Some(0.0);
        setup
    };
    REFLECTORS_MM.iter().flat_map(|reflector| (0..STATIONS_MM.len()).map(|k| at(k, *reflector))).collect()
}

/// Every pose read by every setup, with these location errors; exact kinematics.
fn measured(machine: &Machine, errors: &Errors, noise_mm: f64) -> Run {
    let (mut places, mut noise) = (ChaCha8Rng::seed_from_u64(6), ChaCha8Rng::seed_from_u64(7));
    let setups = setups();
    let poses: Vec<AxisValues<f64>> =
        (0..POSES).map(|_| AxisValues::of(machine.joints(), |_| places.random_range(-2.6..2.6))).collect();
    let mut points = Vec::new();
    for (k, setup) in setups.iter().enumerate() {
        for position in &poses {
            let state = State { position: *position, setup: k, ..State::default() };
            let standard: f64 = StandardNormal.sample(&mut noise);
            let length_mm = predict(machine, setup, &state, errors).x + noise_mm * standard;
            let reading_mm = [length_mm, 0.0, 0.0];
            points.push(Point { state, reading_mm, spread_mm: [0.0; 3], samples: 1, quality: Quality::Good });
        }
    }
    Run {
        name: "robot".into(),
        machine: machine.clone(),
        kind: RunKind::Static,
        setups,
        channels: Vec::new(),
        points,
    }
}

fn fitted(run: &Run) -> Identification {
    let experiment = Experiment::new(std::slice::from_ref(run)).unwrap();
    identify(&experiment, &Model::base(&run.machine.name), &Options::default()).unwrap()
}

/// Location errors of the joints that the fit gives numbers for: joint, component, name.
fn observable(machine: &Machine, fit: &Identification) -> Vec<(usize, usize, String)> {
    let components = ["X", "Y", "Z", "A", "B", "C"];
    let all = machine.tool.iter().enumerate().flat_map(|(joint, axis)| {
        components.iter().enumerate().map(move |(k, c)| (joint, k, format!("E{c}0{}", axis.letter)))
    });
    let seen = |name: &str| fit.parameters.iter().any(|p| p.name == name && p.observable());
    all.filter(|(.., name)| seen(name)).collect()
}

#[test]
fn location_errors_of_six_joints_are_identified_from_tracker_lengths() {
    let robot = robot();
    let nominal = fitted(&measured(&robot, &Errors::default(), NOISE_MM));
    let seen = observable(&robot, &nominal);
    // 24 numbers place six axis lines; six of them are the place of the base among the stations, whose own is unknown; j6 has
    // two more: where it stands in its zero and along its line decides where the reflectors are.
    assert_eq!(seen.len(), 20, "{seen:?}");

    // 0.2 mm and 0.2 mrad in everything the fit gives a number to.
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let mut errors = Errors::default();
    let mut truth = Vec::new();
    for (joint, k, name) in &seen {
        let value: f64 = rng.random_range(-1.0..1.0) * if *k < 3 { 0.2 } else { 0.2e-3 };
        let unit = Vector3::ith(k % 3, value);
        let twist = if *k < 3 { Twist::translation(unit) } else { Twist::rotation(unit) };
        errors.joints[robot.tool[*joint].letter] += twist;
        truth.push((name, value));
    }
    let fit = fitted(&measured(&robot, &errors, NOISE_MM));
    assert!((0.6..1.2).contains(&(fit.rms_mm / NOISE_MM)), "rms {} mm", fit.rms_mm);
    for (name, value) in truth {
        let found = fit.parameters.iter().find(|p| p.name == *name).unwrap();
        let (got, u) = (found.value.unwrap(), found.u.unwrap());
        assert!((got - value).abs() < 5.0 * u, "{name}: {value} injected, {got} ± {u} found");
    }
}
