//! The cycle on the fly, from samples made by hand: C of a shipped machine turns about a ball far out.

use super::*;
use crate::align::{AlignLimits, Aligner};
use trunnion_core::{AxisSample, ProbeSample};
use trunnion_cycles::Cycle;
use trunnion_machine::{Machine, shipped};

const FROM_TO_DEG: (f64, f64) = (0.0, 120.0);

fn machine() -> Machine {
    shipped::machine("table-bc").unwrap()
}

fn cycle(feeds_deg_per_min: &[f64]) -> Cycle {
    let text = format!(
        "format = \"trunnion-cycle/1\"\nname = \"c\"\nmachine = \"table-bc\"\nkind = \"on-the-fly\"\n\
         [[setup]]\nname = \"low\"\ninstrument = \"r-test\"\nball_in_table_mm = [300.0, 0.0, 60.0]\n\
         [sweep]\naxis = \"C\"\nfrom_deg = {}\nto_deg = {}\nfeeds_deg_per_min = {feeds_deg_per_min:?}\nb_deg = 0\n",
        FROM_TO_DEG.0, FROM_TO_DEG.1
    );
    Cycle::parse("c.toml", &text).unwrap()
}

/// Where C is and how fast: forward and back at each feed, with a run-in of 10° and ramps of 0.1 s; every ms.
fn motion(cycle: &Cycle) -> Vec<f64> {
    let (mut angles, mut angle) = (Vec::new(), -10f64.to_radians());
    for pass in cycle.sweeps() {
        let (feed, mut speed) = (pass.feed_rad_per_s, 0.0f64);
        let stop = |angle: f64| {
            if feed > 0.0 { angle > 130f64.to_radians() } else { angle < -10f64.to_radians() }
        };
        while !stop(angle) {
            speed = (speed + feed / 100.0).clamp(-feed.abs(), feed.abs());
            angle += speed * 1e-3;
            angles.push(angle);
        }
    }
    angles
}

/// What the alignment gives: probes every ms, axes every 8 ms with stamps that jitter (rms). The probes read 1 + angle/1000, 0, 1.
fn aligned(cycle: &Cycle, jitter_s: f64, spoil: impl Fn(usize, &mut f64)) -> Vec<Aligned> {
    aligned_along(cycle, motion(cycle), jitter_s, spoil)
}

fn aligned_along(
    cycle: &Cycle,
    angles: Vec<f64>,
    jitter_s: f64,
    spoil: impl Fn(usize, &mut f64),
) -> Vec<Aligned> {
    let mut aligner = Aligner::new(&[0, 1, 2], AlignLimits::default());
    let (machine, mut steps) = (machine(), Vec::new());
    // A sequence without runs, evenly from −√3 to √3.
    let mut unit = 0.5_f64;
    for (k, angle) in angles.into_iter().enumerate() {
        let time_s = k as f64 * 1e-3;
        if k % 8 == 0 {
            unit = (unit + 0.618_033_988_749_895).fract();
            let mut rotary = AxisValues::default();
            rotary[Joint::C] = angle;
            let position = cycle.position(&machine, 0, &rotary).unwrap();
            let time_s = time_s + jitter_s * 12f64.sqrt() * (unit - 0.5);
            aligner.push_axes(&AxisSample { time_s, position, ..AxisSample::default() }, &mut steps);
        }
        for (channel, mut value_mm) in [(0, angle), (1, 0.0), (2, 1.0)] {
            if channel == 2 {
                spoil(k, &mut value_mm);
            }
            let sample = ProbeSample { channel, time_s, value_mm, ..ProbeSample::default() };
            aligner.push_probe(&sample, &mut steps);
        }
    }
    aligner.finish(&mut steps);
    steps
}

fn swept(cycle: &Cycle, steps: &[Aligned]) -> (SweepCycle, Vec<Point>) {
    let course = Course::of(&machine(), cycle).unwrap();
    let rules = SweepRules::of(cycle).unwrap();
    let mut sweep = SweepCycle::new(rules, course, NestCalibration::orthogonal(), 0);
    let mut points = Vec::new();
    steps.iter().for_each(|step| sweep.push(step, &mut points));
    sweep.finish(&mut points);
    (sweep, points)
}

#[test]
fn every_pass_gives_points_at_the_target_rate_with_angle_and_reading_of_one_instant() {
    let cycle = cycle(&[1800.0, 2400.0]);
    let (sweep, points) = swept(&cycle, &aligned(&cycle, 0.0, |_, _| {}));
    // 120° at 30 and 40°/s, both ways, 100 points a second
    assert!((1390..1410).contains(&points.len()), "{}", points.len());
    for point in &points {
        let angle = point.state.position[Joint::C];
        assert!((0.0..=120.0).contains(&angle.to_degrees()));
        assert!((point.reading_mm[0] - angle).abs() < 1e-6 && point.samples <= 11);
        let velocity = point.state.velocity[Joint::C];
        assert_eq!(velocity.signum(), point.state.direction[Joint::C]);
    }
    assert_eq!((sweep.progress().done, sweep.progress().total), (4, 4));
    assert!(sweep.progress().seconds_left.unwrap() < 0.2);
    assert!(sweep.counts().share_used().unwrap() > 0.999, "{:?}", sweep.counts());
}

#[test]
fn a_fast_turn_far_out_stays_on_its_circle_however_the_stamps_jitter() {
    let cycle = cycle(&[7200.0]);
    for jitter_s in [0.0, 0.6e-3] {
        let (sweep, points) = swept(&cycle, &aligned(&cycle, jitter_s, |_, _| {}));
        for point in &points {
            let on_course = cycle.position(&machine(), 0, &point.state.position).unwrap();
            let off = Joint::LINEAR.map(|axis| (point.state.position[axis] - on_course[axis]).abs());
            // The mean of 1.2° of a circle of 300 mm lies 5.5 µm inside it.
            assert!(off.iter().all(|off_mm| *off_mm < 1e-7), "{off:?}");
        }
        let share = sweep.counts().share_used().unwrap();
        assert!(share > 0.95, "{share} at {jitter_s} s: {:?}", sweep.counts());
        let measured_s = sweep.counts().jitter_s().unwrap();
        assert!((measured_s - jitter_s).abs() < 0.1e-3, "{measured_s} s for {jitter_s} s");
    }
}

/// From where the axis stood to the first pass and back there again leads through the span, at no feed of the cycle.
#[test]
fn the_way_to_a_pass_and_home_from_it_are_not_asked_for() {
    let cycle = cycle(&[1800.0]);
    let passes = motion(&cycle);
    let (first, last) = (passes[0], passes[passes.len() - 1]);
    // A second each, as a controller speeds up and slows down.
    let way = |from: f64, to: f64| {
        let share = |k: u32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(k) * 1e-3).cos();
        (0..1000).map(move |k| from + (to - from) * share(k))
    };
    let stood = 60f64.to_radians();
    let angles = way(stood, first).chain(passes.iter().copied()).chain(way(last, stood)).collect();
    let (sweep, points) = swept(&cycle, &aligned_along(&cycle, angles, 0.0, |_, _| {}));
    let (of_passes, _) = swept(&cycle, &aligned(&cycle, 0.0, |_, _| {}));
    assert!(sweep.counts().share_used().unwrap() > 0.99, "{:?}", sweep.counts());
    assert!(sweep.counts().used.abs_diff(of_passes.counts().used) <= 2 && !points.is_empty());
}

/// With the override at 80 % no sample is at the feed: nothing is used, and every sample of the passes is counted.
#[test]
fn a_pass_at_another_speed_is_counted() {
    let (cycle, slower) = (cycle(&[1800.0]), cycle(&[1440.0]));
    let (sweep, points) = swept(&cycle, &aligned_along(&cycle, motion(&slower), 0.0, |_, _| {}));
    // 120° at 24°/s, both ways, every ms.
    assert!(points.is_empty() && sweep.counts().other_speed.abs_diff(10_000) < 100, "{:?}", sweep.counts());
}

#[test]
fn a_missing_value_breaks_the_average_and_is_counted_with_its_share() {
    let cycle = cycle(&[1800.0]);
    let steps = aligned(&cycle, 0.0, |k, value_mm| {
        if k == 3000 {
            *value_mm = f64::NAN;
        }
    });
    let (sweep, points) = swept(&cycle, &steps);
    assert_eq!(sweep.counts().incomplete, 1);
    assert!(points.iter().all(|point| point.reading_mm[2] == 1.0));
    let summary = sweep.counts().summary().unwrap();
    assert!(summary.contains("1 excluded (0.0 %): a channel had no value"), "{summary}");
    assert_eq!(sweep.counts().used, points.iter().map(|point| u64::from(point.samples)).sum::<u64>());
}

/// A curve has no encoder: what follows the end of a pass looks like the beginning of another.
#[test]
fn the_run_out_of_a_circle_is_no_sample_of_a_pass() {
    let text = "format = \"trunnion-cycle/1\"\nname = \"c\"\nmachine = \"table-bc\"\nkind = \"on-the-fly\"\n\
                passes = [\"+\", \"-\"]\n[[setup]]\nname = \"xy\"\ninstrument = \"ball-bar\"\nbar_length_mm = 100\n\
                ball_in_table_mm = [30.0, 0.0, 60.0]\n\
                [circle]\nplane = \"XY\"\nfrom_deg = 0\nto_deg = 360\nfeeds_mm_per_min = [6000]\n";
    let (cycle, machine) = (Cycle::parse("c.toml", text).unwrap(), machine());
    // 1 rad/s, every 5 ms; 0.15 rad before and after each pass, and a second of standing.
    let (step_rad, step_s, run_in_rad) = (5e-3, 5e-3, 0.15);
    let forward = (0..).map(|k| f64::from(k) * step_rad - run_in_rad);
    let forward: Vec<f64> = forward.take_while(|angle| *angle < std::f64::consts::TAU + run_in_rad).collect();
    let stand = |angle: f64| std::iter::repeat_n(angle, 200);
    let angles = stand(forward[0])
        .chain(forward.iter().copied())
        .chain(stand(forward[forward.len() - 1]))
        .chain(forward.iter().rev().copied())
        .chain(stand(forward[0]));
    let (mut aligner, mut steps) = (Aligner::new(&[0], AlignLimits::default()), Vec::new());
    for (k, angle) in angles.enumerate() {
        let time_s = k as f64 * step_s;
        let position = cycle.curve_position(&machine, 0, angle, &AxisValues::default()).unwrap();
        aligner.push_axes(&AxisSample { time_s, position, ..AxisSample::default() }, &mut steps);
        aligner.push_probe(&ProbeSample { time_s, ..ProbeSample::default() }, &mut steps);
    }
    aligner.finish(&mut steps);
    let (sweep, _) = swept(&cycle, &steps);
    let counts = sweep.counts();
    assert_eq!(counts.unplanned, 0, "{counts:?}");
    let in_passes = 2.0 * std::f64::consts::TAU / step_rad;
    assert!((counts.used as f64 / in_passes - 1.0).abs() < 0.01, "{counts:?} of {in_passes}");
    assert_eq!((sweep.progress().done, sweep.progress().total), (2, 2));
}
