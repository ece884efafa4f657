//! Every ball-bar cycle is read live: its NC program, samples of axes and bar, points, and the base model fitted to them, against
//! a virtual machine.

use crate::cycle_program::CycleProgram;
use trunnion_core::{AxisSample, Channel, Point, ProbeSample, Quality, Role};
use trunnion_cycles::{CourseRules, Cycle, Run};
use trunnion_effects::Model;
use trunnion_engine::Experiment;
use trunnion_hil_sim::{Truth, VirtualMachine};
use trunnion_machine::{Machine, shipped};
use trunnion_sync::forming::Forming;
use trunnion_sync::plan::Plan;
use trunnion_sync::{CycleEvent, EndReason, NestCalibration};
use trunnion_tests::{mounted, workspace_root};

const CYCLES: [&str; 14] = [
    "ball-bar-c",
    "bk1-a",
    "bk1-b",
    "bk2-c",
    "bk2-c-of-ac",
    "s4-b",
    "s4-c",
    "head-b",
    "head-c",
    "circle-xy",
    "circle-yz",
    "circle-zx",
    "bk3-bc",
    "bk4-cone",
];
/// Axis samples and bar samples, s.
const STEP_S: f64 = 0.01;
/// Machines whose calibrated bars are looked at.
const SEEDS: u64 = 12;
/// An operator who is quick, s.
const OPERATOR_S: f64 = 5.0;
/// A nest that stands in the configuration although the cycle measures with the bar.
const TRIPOD: [[f64; 3]; 3] = [[0.816, 0.0, 0.577], [-0.408, 0.707, 0.577], [-0.408, -0.707, 0.577]];

struct Measured {
    cycle: Cycle,
    machine: Machine,
    world: VirtualMachine,
    points: Vec<Point>,
    ended: Option<EndReason>,
}

/// The points of a cycle whose program a controller runs, read by a bar that shows what the virtual machine does.
fn measured(name: &str) -> Measured {
    measured_by(name, 7, 0.0)
}

/// The same of the machine of this seed, by a bar whose device counts from `zero_mm` and whose configuration does not say so.
fn measured_by(name: &str, seed: u64, zero_mm: f64) -> Measured {
    let path = workspace_root().join(format!("config/cycles/{name}.toml"));
    let cycle = Cycle::parse(name, &std::fs::read_to_string(path).unwrap()).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    let truth = Truth::draw(&machine, &mounted(&cycle), &[], 600.0, seed).unwrap();
    let world = VirtualMachine::new(machine.clone(), truth).unwrap();

    let mut rows = NestCalibration::orthogonal();
    rows.nest_from_probes = nalgebra::Matrix3::from_fn(|i, j| TRIPOD[i][j]).try_inverse().unwrap();
    let channels = vec![Channel { device: 0, name: "bar".into(), role: Role::Bar }];
    let plan = Plan { machine: machine.clone(), cycle: cycle.clone(), nest: rows, channels };
    let mut forming = Forming::new(&plan, 0).unwrap_or_else(|error| panic!("{name}: {error}"));
    let program = CycleProgram::of(&cycle, &machine, &CourseRules::default(), OPERATOR_S);
    let mut out = Vec::new();
    for tick in 0..(program.trajectory.duration_s() / STEP_S) as u32 {
        let time_s = f64::from(tick) * STEP_S;
        let here = program.trajectory.at(time_s);
        forming.axes(&AxisSample { time_s, position: here.position, ..AxisSample::default() }, &mut out);
        if let Some(setup) = program.setup_of_step[here.step] {
            let value_mm = zero_mm + world.ideal_reading_mm(setup, &here.state(time_s, Vec::new(), setup))[0];
            forming.probe(&ProbeSample { channel: 0, time_s, value_mm, ..ProbeSample::default() }, &mut out);
        }
    }
    forming.finish(EndReason::ControllerEnded, &mut out);
    let points = out.into_iter().filter_map(|event| match event {
        CycleEvent::Point { point, .. } => Some(point),
        _ => None,
    });
    Measured { points: points.collect(), ended: forming.ended(), cycle, machine, world }
}

#[test]
fn every_pass_of_every_bar_cycle_gives_points_with_the_reading_of_the_bar() {
    for name in CYCLES {
        let Measured { cycle, world, points, ended, .. } = measured(name);
        assert_eq!(ended, Some(EndReason::ControllerEnded), "{name}");
        for (setup, placed) in cycle.setups.iter().enumerate() {
            let mine: Vec<&Point> = points.iter().filter(|point| point.state.setup == setup).collect();
            let seconds: f64 = cycle
                .sweeps()
                .iter()
                .filter(|sweep| sweep.setup == setup)
                .map(|sweep| span(&cycle) / sweep.feed_rad_per_s.abs())
                .sum();
            let share = mine.len() as f64 / (100.0 * seconds);
            assert!(share > 0.95, "{name}, {}: {} points in {seconds} s", placed.name, mine.len());
            let truth = |point: &Point| world.ideal_reading_mm(setup, &point.state)[0];
            let zero_mm = if placed.calibrated { 0.0 } else { truth(mine[0]) };
            for point in &mine {
                assert_eq!(point.quality, Quality::Good);
                let off_mm = point.reading_mm[0] - (truth(point) - zero_mm);
                assert!(
                    off_mm.abs() < 1e-4,
                    "{name}, {}: {off_mm} mm at {:?}",
                    placed.name,
                    point.state.position
                );
                assert!(point.reading_mm[1] == 0.0 && point.reading_mm[2] == 0.0, "{name}: {point:?}");
            }
        }
    }
}

fn span(cycle: &Cycle) -> f64 {
    match &cycle.motion {
        trunnion_cycles::cycle::Motion::OnTheFly { from_to_rad: (from, to), .. }
        | trunnion_cycles::cycle::Motion::Path { from_to_rad: (from, to), .. } => (to - from).abs(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_zero_that_nobody_took_off_a_calibrated_length_is_named_and_no_machine_is_doubted() {
    for name in ["s4-b", "s4-c"] {
        for seed in 0..SEEDS {
            // Both signs, from a little more than balls set by hand are off to half the travel of an encoder.
            let size_mm = 1.5 * (500.0_f64 / 1.5).powf(seed as f64 / (SEEDS - 1) as f64);
            let zero_mm = if seed % 2 == 0 { size_mm } else { -size_mm };
            for zero_mm in [0.0, zero_mm] {
                let Measured { cycle, machine, points, .. } = measured_by(name, seed, zero_mm);
                let points: Vec<Point> = points.into_iter().step_by(10).collect();
                let (kind, setups) = (cycle.run_kind(), cycle.setups);
                let run = Run { name: name.into(), machine, kind, setups, channels: vec![], points };
                let found = trunnion_engine::plausibility::implausible(&[run]);
                match (zero_mm == 0.0, found.as_slice()) {
                    (true, []) => {}
                    (false, [one]) => {
                        assert!(one.finding.contains("calibrated length"), "{one:?}");
                        let said: f64 = one.hypothesis.split_once("zero of the bar, ").unwrap().1[..]
                            .split(' ')
                            .next()
                            .unwrap()
                            .replace('−', "-")
                            .parse()
                            .unwrap();
                        assert!((said - zero_mm).abs() < 0.1, "{name}, seed {seed}: {said} of {zero_mm}");
                        assert!(one.rms_um_with_it.unwrap() < 500.0, "{one:?}");
                    }
                    (_, found) => panic!("{name}, seed {seed}, zero {zero_mm} mm: {found:?}"),
                }
            }
        }
    }
}

#[test]
fn every_bar_cycle_gives_a_result() {
    for name in CYCLES {
        let Measured { cycle, machine, points, .. } = measured(name);
        // A tenth of the points: what is asked is whether there is a result.
        let points: Vec<Point> = points.into_iter().step_by(10).collect();
        let kind = cycle.run_kind();
        let run = Run { name: name.into(), machine, kind, setups: cycle.setups, channels: vec![], points };
        let experiment = Experiment::new(&[run]).unwrap();
        let model = Model::base(&experiment.machine().name);
        let fit = trunnion_engine::identify(&experiment, &model, &Default::default());
        let fit = fit.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(fit.rms_mm < 1e-3, "{name}: {} mm", fit.rms_mm);
        assert!(fit.parameters.iter().any(|parameter| parameter.observable()), "{name}");
    }
}
