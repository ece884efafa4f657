//! A robot of six joints through the binary: a table of a laser tracker, identification, diagnosis, and poses that took no part.

use crate::program::{json, trunnion};
use nalgebra::{Point3, Vector3};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use trunnion_core::{AxisValues, InstrumentKind, State};
use trunnion_hil_sim::truth::Noise;
use trunnion_hil_sim::{Instrument, NestOn, Sampler, SimSetup, Truth, VirtualMachine};
use trunnion_machine::Machine;

const UR5: &str = include_str!("../../config/robots/ur5.toml");
/// On the line of j6, 31 mm beyond the flange.
const REFLECTOR_MM: [f64; 3] = [-817.25, -222.45, -5.491];
/// Noise of a coordinate, mm: a laser tracker two metres away.
const NOISE_MM: f64 = 0.02;
/// What the encoder of j2 is wrong by, rad: amplitude of cos j2.
const WAVE_RAD: f64 = 300e-6;
/// Location errors of the robot: joint, component (x y z a b c), mm or rad.
const LOCATION: [(&str, usize, f64); 4] =
    [("j2", 3, 400e-6), ("j3", 0, 0.5), ("j4", 0, -0.3), ("j5", 3, -500e-6)];

/// `setup.toml` for a table with columns of this tracker program.
const SETUP: &str = include_str!("../data/robot/setup.toml");

/// The model of docs/use/robot.md: nothing of it is a setting, so that a prediction is wholly frozen.
fn model(effects: &[String]) -> String {
    let mut text = "format = \"trunnion-model/1\"\nmachine = \"ur5\"\n[[effect]]\nid = \"location-errors\"\n"
        .to_string();
    for axis in ["x", "y", "z"] {
        writeln!(
            text,
            "[[effect]]\nid = \"formula:reflector-{axis}\"\nsite = \"spindle\"\ncomponent = \"d{axis}\"\nexpression = \"shift\""
        )
        .unwrap();
    }
    effects.iter().for_each(|id| writeln!(text, "[[effect]]\nid = \"{id}\"").unwrap());
    text
}

/// Robot, setup file and models in `folder`; gives the path of a file there.
fn folder_of(folder: &Path) -> impl Fn(&str) -> String {
    let encoders: Vec<String> = (1..=6).map(|k| format!("encoder-eccentricity:j{k}")).collect();
    let files = [
        ("ur5.toml", UR5.to_string()),
        ("setup.toml", SETUP.into()),
        ("geometry.toml", model(&[])),
        ("encoder.toml", model(&encoders[1..2])),
        ("encoders.toml", model(&encoders)),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let folder = folder.to_path_buf();
    move |name: &str| folder.join(name).display().to_string()
}

/// The robot measures poses: a table of targets and differences. Poses `first…` of a sequence that fills the joints' ranges evenly.
fn measured(first: usize, count: usize) -> String {
    let robot = Machine::parse("ur5", "ur5.toml", UR5).unwrap();
    let instrument = Instrument::new(InstrumentKind::LaserTracker);
    let mut setup = SimSetup::new("tracker", NestOn::Table, Point3::origin(), instrument);
    setup.ball_in_tool_mm = Point3::from(REFLECTOR_MM);
    let nominal = VirtualMachine::new(robot.clone(), Truth::perfect("ur5", &[setup.clone()], 1.0)).unwrap();
    let mut truth = Truth::perfect("ur5", &[setup], 1.0);
    (truth.noise, truth.seed) = (Noise { white_mm: NOISE_MM, ..Noise::NONE }, 5 + first as u64);
    for (joint, component, amount) in LOCATION {
        let error = &mut truth.location[robot.joint(joint).unwrap()];
        let unit = Vector3::ith(component % 3, amount);
        if component < 3 { error.translation_mm += unit } else { error.rotation_rad += unit }
    }
    let real = VirtualMachine::new(robot.clone(), truth).unwrap();
    let mut sampler = Sampler::new(&real, 0);
    let j2 = robot.joint("j2").unwrap();
    let mut table =
        "step_order,x_t,y_t,z_t,x_dif,y_dif,z_dif,joint_1,joint_2,joint_3,joint_4,joint_5,joint_6\n"
            .to_string();
    for pose in first..first + count {
        // Multiples of square roots of primes, modulo 1: [Roberts 2018] in spirit, irrational and so never the same pose.
        let share = |k: usize| ([2.0, 3.0, 5.0, 7.0, 11.0, 13.0f64][k].sqrt() * (pose + 1) as f64).fract();
        let joints = robot.joints();
        let degrees: Vec<f64> = (0..6).map(|k| (300.0 * share(k) - 150.0).round()).collect();
        let at = |joint| degrees[joints.iter().position(|other| *other == joint).unwrap()].to_radians();
        let commanded = State { position: AxisValues::of(joints.clone(), at), ..State::default() };
        let mut actual = commanded.clone();
        actual.position[j2] += WAVE_RAD * commanded.position[j2].cos();
        let target = nominal.ideal_reading_mm(0, &commanded);
        let place = sampler.read_mm(&real, &actual);
        let row: Vec<f64> =
            target.into_iter().chain((0..3).map(|k| place[k] - target[k])).chain(degrees).collect();
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(table, "{pose},{}", cells.join(",")).unwrap();
    }
    table
}

/// Mean distance of the poses of `run` from what the model predicts, frozen, µm.
fn mean_distance_um(model: &str, fitted: &str, run: &str) -> f64 {
    trunnion(&["identify", fitted, "--model", model, "--keep"]);
    let prediction = json(&["predict", run, "--model", model, "--json"]);
    assert_eq!(prediction["runs"][0]["fitted_settings"].as_array().unwrap().len(), 0, "{prediction}");
    prediction["runs"][0]["mean_distance_um"].as_f64().unwrap()
}

#[test]
fn the_encoder_of_a_robot_is_found_and_other_poses_are_predicted_to_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder_of(folder.path());
    for (name, first, count) in [("grid", 0, 300), ("random", 1000, 40)] {
        std::fs::write(at(&format!("{name}.csv")), measured(first, count)).unwrap();
        let (table, run) = (at(&format!("{name}.csv")), at(&format!("{name}.mcap")));
        trunnion(&["import", &table, "--setup", &at("setup.toml"), "-o", &run]);
    }
    let (grid, random) = (at("grid.mcap"), at("random.mcap"));
    let diagnosis = json(&["diagnose", &grid, "--json"]);
    assert_eq!(diagnosis["verdict"], "missing-effect", "{diagnosis}");
    assert_eq!(diagnosis["candidates"][0]["effect"], "encoder-eccentricity:j2", "{diagnosis}");

    let geometry_um = mean_distance_um(&at("geometry.toml"), &grid, &random);
    let encoder_um = mean_distance_um(&at("encoder.toml"), &grid, &random);
    // Mean length of three normal numbers: √(8/π) σ; a tenth more for the parameters of 300 poses.
    let noise_um = (8.0 / std::f64::consts::PI).sqrt() * 1e3 * NOISE_MM;
    assert!(encoder_um < 1.25 * noise_um, "{encoder_um} µm of {noise_um}");
    assert!(geometry_um > 2.0 * encoder_um, "{geometry_um} µm, {encoder_um} µm");

    let fit = json(&["identify", &grid, "--model", &at("encoder.toml"), "--json"]);
    let of_joint = |p: &&serde_json::Value| p["effect"] == "encoder-eccentricity:j2" && p["name"] == "cos2";
    let second = fit["parameters"].as_array().unwrap().iter().find(of_joint).unwrap();
    let (value, u) = (second["value"].as_f64().unwrap(), second["u"].as_f64().unwrap());
    assert!(value.abs() < 4.5 * u, "no second order was injected: {second}");
}

/// Reads the files of `serial_robots_datasets` [Jacobi 2025] as they are: docs/measured/robot.md.
#[test]
#[ignore = "TRUNNION_ROBOT_DATA must name the folder of the published files"]
fn random_poses_of_a_real_arm_are_predicted_better_with_its_encoders() {
    let data =
        PathBuf::from(std::env::var_os("TRUNNION_ROBOT_DATA").expect("the folder of the published files"));
    let folder = tempfile::tempdir().unwrap();
    let at = folder_of(folder.path());
    let import = |table: &str, run: &str| {
        let table = data.join(table).display().to_string();
        trunnion(&["import", &table, "--setup", &at("setup.toml"), "-o", &at(run)]);
        at(run)
    };
    let (grid, random) = (import("ur5_grid.csv", "grid.mcap"), import("ur5_random.csv", "random.mcap"));
    // Figures of an independent fit of the same data: 0.102 mm, and 0.0904 mm with encoders.
    assert!(mean_distance_um(&at("geometry.toml"), &grid, &random) < 102.0);
    assert!(mean_distance_um(&at("encoders.toml"), &grid, &random) < 90.4);
}
