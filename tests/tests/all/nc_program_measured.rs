//! A controller that runs our NC program is measured by our own acquisition: every pose settles, every pass is swept.

use crate::interpreter::{Event, interpret};
use trunnion_core::{AxisSample, AxisValues, Joint, ProbeSample, Quality, convert};
use trunnion_cycles::CourseRules;
use trunnion_cycles::Cycle;
use trunnion_cycles::cycle::Motion;
use trunnion_cycles::nc::{DIALECTS, Program};
use trunnion_machine::{Machine, shipped};
use trunnion_sync::{
    AlignLimits, Aligned, Aligner, Course, CycleEvent, EndReason, NestCalibration, StaticCycle, StaticRules,
    SweepCycle, SweepRules,
};
use trunnion_tests::workspace_root;

/// Time between two samples, s.
const STEP_S: f64 = 0.02;
/// An operator who is quick, s.
const OPERATOR_S: f64 = 5.0;
/// After a stop the structure swings back by this much, mm …
const TAIL_MM: f64 = 5e-3;
/// … within this time constant, s.
const TAIL_S: f64 = 0.4;

fn cycle(name: &str) -> (Cycle, Machine) {
    let path = workspace_root().join("config/cycles").join(name);
    let cycle = Cycle::parse(name, &std::fs::read_to_string(path).unwrap()).unwrap();
    let machine = shipped::machine(&cycle.machine).unwrap();
    (cycle, machine)
}

/// Samples of axes and probes while a controller runs the program of a cycle.
fn run(cycle: &Cycle, machine: &Machine, dialect: usize) -> Vec<Aligned> {
    let program = Program::of_cycle(cycle, machine, &CourseRules::default()).unwrap();
    let dialect = DIALECTS[dialect];
    let events = interpret(dialect.name, &(dialect.write)(&program, dialect.decimals));
    let mut aligner = Aligner::new(&[0, 1, 2], AlignLimits::default());
    let mut out = Vec::new();
    let (mut at, mut begins_s, mut ticks, mut stopped_s) = (AxisValues::<f64>::default(), 0.0, 0u32, 0.0);
    for event in &events {
        let (to, seconds) = match event {
            Event::Move { to, seconds } => (*to, *seconds),
            Event::Dwell { seconds } => (at, *seconds),
            Event::Stop(_) => (at, OPERATOR_S),
        };
        let ends_s = begins_s + seconds;
        while f64::from(ticks) * STEP_S < ends_s {
            let time_s = f64::from(ticks) * STEP_S;
            let share = (time_s - begins_s) / seconds;
            let position = AxisValues::from_fn(|letter| {
                let edge = at[letter] + (to[letter] - at[letter]) * share;
                if letter.is_rotary() { convert::rad_from_deg(edge) } else { edge }
            });
            if to != at {
                stopped_s = time_s;
            }
            aligner.push_axes(&AxisSample { time_s, position, ..AxisSample::default() }, &mut out);
            let value_mm = TAIL_MM * (-(time_s - stopped_s) / TAIL_S).exp();
            for channel in 0..3 {
                let sample = ProbeSample { channel, time_s, value_mm, ..ProbeSample::default() };
                aligner.push_probe(&sample, &mut out);
            }
            ticks += 1;
        }
        (at, begins_s) = (to, ends_s);
    }
    aligner.finish(&mut out);
    out
}

#[test]
fn every_pose_of_a_static_program_settles_within_its_dwell() {
    let (cycle, machine) = cycle("r-test-interleaved.toml");
    let Motion::Static { settle, .. } = cycle.motion else { panic!("a cycle at rest") };
    let poses = cycle.poses(&machine).unwrap();
    for dialect in 0..DIALECTS.len() {
        let axes = machine.axes().map(|axis| axis.letter).collect();
        let rules = StaticRules::new(settle).with_wait(cycle.rounds.wait_s);
        let mut watch = StaticCycle::new(poses.clone(), rules, vec![], axes, 0);
        let steps = run(&cycle, &machine, dialect);
        let last_s = steps.last().unwrap().state.time_s;
        let mut events = Vec::new();
        steps.iter().for_each(|step| watch.push(step, &mut events));
        watch.finish(EndReason::Stopped, last_s, &mut events);
        let name = DIALECTS[dialect].name;
        let mut read = 0;
        for event in &events {
            match event {
                CycleEvent::Point { pose, point, .. } => {
                    assert_eq!(point.quality, Quality::Good, "{name}, pose {pose}");
                    read += 1;
                }
                CycleEvent::Ended { reason, .. } => assert_eq!(*reason, EndReason::Complete, "{name}"),
                CycleEvent::UnknownDwell { .. } | CycleEvent::Samples { .. } => {}
            }
        }
        assert_eq!(read, poses.len(), "{name}");
    }
}

#[test]
fn every_pass_of_a_program_on_the_fly_is_swept_at_its_feed() {
    let (cycle, machine) = cycle("r-test-sweep-c.toml");
    for dialect in 0..DIALECTS.len() {
        let name = DIALECTS[dialect].name;
        let (rules, course) = (SweepRules::of(&cycle).unwrap(), Course::of(&machine, &cycle).unwrap());
        let mut watch = SweepCycle::new(rules, course, NestCalibration::orthogonal(), 0);
        let steps = run(&cycle, &machine, dialect);
        let mut points = Vec::new();
        steps.iter().for_each(|step| watch.push(step, &mut points));
        watch.finish(&mut points);
        assert_eq!((watch.progress().done, watch.progress().total), (4, 4), "{name}");
        // A turn each way at 30 and at 60 degrees a second; in 0.02 s that is too far to be averaged.
        let expected = 2.0 * (12.0 + 6.0) / STEP_S;
        assert!((points.len() as f64 / expected - 1.0).abs() < 0.05, "{name}: {} points", points.len());
        for point in &points {
            // Blocks of the program are chords of the circle.
            let nominal = cycle.position(&machine, 0, &point.state.position).unwrap();
            let off = Joint::LINEAR.map(|letter| (point.state.position[letter] - nominal[letter]).abs());
            assert!(off.iter().all(|mm| *mm < 0.01), "{name}: {off:?}");
        }
    }
}
