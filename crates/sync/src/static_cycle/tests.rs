use super::*;
use crate::align::{AlignLimits, Aligner};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trunnion_core::axis::iso::{B, C, X, Y, Z};
use trunnion_core::{AxisSample, ProbeSample};
use trunnion_cycles::cycle::Settle;

const SETTLE: Settle = Settle {
    window_s: 0.5,
    drift_mm: 0.5e-3,
    noise_mm: 2e-3,
    standstill_mm: 2e-3,
    standstill_rad: 2e-5,
    timeout_s: 3.0,
};

/// One leg of the machine's way: go to C in 0.4 s, stand there.
#[derive(Clone, Copy)]
struct Leg {
    c_rad: f64,
    stand_s: f64,
}

/// A machine whose C turns through legs, with probes that read what `reading` says plus noise.
struct Shop<'a> {
    legs: &'a [Leg],
    /// (time, time since this stand began, c) → probes.
    reading: &'a dyn Fn(f64, f64, f64) -> [f64; 3],
    noise_mm: f64,
}

impl Shop<'_> {
    /// Aligned steps at 1 kHz and 100 Hz.
    fn run(&self) -> Vec<Aligned> {
        self.read_every(1)
    }

    /// The same with probes that are read every so many ms.
    fn read_every(&self, probe_ms: u32) -> Vec<Aligned> {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut aligner = Aligner::new(&[0, 1, 2], AlignLimits::default());
        let (mut out, mut ms, mut from) = (Vec::new(), 0u32, self.legs[0].c_rad - 0.5);
        for leg in self.legs {
            for step in 0..(400.0 + leg.stand_s * 1e3) as u32 {
                let (t, on_way) = (f64::from(ms) * 1e-3, (f64::from(step) / 400.0).min(1.0));
                let c = from + (leg.c_rad - from) * (1.0 - (std::f64::consts::PI * on_way).cos()) / 2.0;
                if ms.is_multiple_of(10) {
                    let mut position = AxisValues::default();
                    position[C] = c + 1e-6 * (rng.random::<f64>() - 0.5);
                    position[X] = 1e-4 * (rng.random::<f64>() - 0.5);
                    let sample = AxisSample { time_s: t, position, ..AxisSample::default() };
                    aligner.push_axes(&sample, &mut out);
                }
                let values = (self.reading)(t, f64::from(step) * 1e-3 - 0.4, c);
                let probes_due = ms.is_multiple_of(probe_ms);
                for (channel, value) in (0u16..).zip(values).filter(|_| probes_due) {
                    // uniform over ±√3·σ has the standard deviation σ
                    let value_mm = value + self.noise_mm * 3f64.sqrt() * (2.0 * rng.random::<f64>() - 1.0);
                    let time_s = t + 1e-5 * f64::from(channel);
                    if value.is_finite() || value.is_nan() && channel != 1 {
                        let sample = ProbeSample { channel, time_s, value_mm, ..ProbeSample::default() };
                        aligner.push_probe(&sample, &mut out);
                    }
                }
                ms += 1;
            }
            from = leg.c_rad;
        }
        aligner.finish(&mut out);
        out
    }
}

fn poses(stations: &[f64]) -> Vec<Pose> {
    let pose = |&c_rad: &f64| {
        let (mut position, mut direction) = (AxisValues::default(), AxisValues::default());
        position[C] = c_rad;
        direction[C] = 1.0;
        Pose { setup: 0, target: 0, position, direction }
    };
    stations.iter().map(pose).collect()
}

fn legs(stations: &[f64], stand_s: f64) -> Vec<Leg> {
    stations.iter().map(|&c_rad| Leg { c_rad, stand_s }).collect()
}

fn cycle(stations: &[f64]) -> StaticCycle {
    StaticCycle::new(poses(stations), StaticRules::new(SETTLE), vec![], vec![X, Y, Z, B, C], 1)
}

fn play(cycle: &mut StaticCycle, steps: &[Aligned]) -> Vec<CycleEvent> {
    let mut events = Vec::new();
    steps.iter().for_each(|step| cycle.push(step, &mut events));
    cycle.finish(EndReason::Stopped, steps.last().map_or(0.0, |step| step.state.time_s), &mut events);
    events
}

fn points(events: &[CycleEvent]) -> Vec<Point> {
    let found: Vec<(usize, Point)> = events
        .iter()
        .filter_map(|event| match event {
            CycleEvent::Point { pose, point, .. } => Some((*pose, point.clone())),
            _ => None,
        })
        .collect();
    assert!(found.iter().enumerate().all(|(i, (pose, _))| i == *pose), "poses come in order, each once");
    found.into_iter().map(|(_, point)| point).collect()
}

fn qualities(events: &[CycleEvent]) -> Vec<Quality> {
    points(events).iter().map(|point| point.quality).collect()
}

fn end(events: &[CycleEvent]) -> EndReason {
    match events.last() {
        Some(CycleEvent::Ended { reason, .. }) => *reason,
        other => panic!("{other:?}"),
    }
}

use Quality::{Good, NoReading, Unsettled};

#[test]
fn every_pose_of_a_quiet_cycle_is_read_with_median_spread_direction_and_time() {
    let stations = [0.0, 0.5, 1.0, 0.2];
    let reading = |_: f64, _: f64, c: f64| [0.01 * c, -0.02, 0.03 + 0.001 * c];
    let steps = Shop { legs: &legs(&stations, 1.5), reading: &reading, noise_mm: 0.5e-3 }.run();
    let mut cycle = cycle(&stations);
    cycle.set_temperature(0, 21.5);
    let events = play(&mut cycle, &steps);
    assert_eq!((qualities(&events), end(&events)), (vec![Good; 4], EndReason::Complete));
    for (point, (c, direction)) in
        points(&events).iter().zip([(0.0, 1.0), (0.5, 1.0), (1.0, 1.0), (0.2, -1.0)])
    {
        let expected = reading(0.0, 0.0, c);
        for k in 0..3 {
            assert!((point.reading_mm[k] - expected[k]).abs() < 0.15e-3, "{point:?}");
            assert!((0.3e-3..0.9e-3).contains(&point.spread_mm[k]), "{point:?}");
        }
        assert_eq!((point.state.position[C], point.state.direction[C]), (c, direction));
        assert!((495..=502).contains(&point.samples), "{}", point.samples);
        assert_eq!(point.state.temperature_degc, [21.5]);
    }
    let time = points(&events)[1].state.time_s.unwrap();
    assert!((2.3..3.3).contains(&time), "{time}"); // second stand: 2.3 s to 3.8 s
}

#[test]
fn a_reading_waits_until_the_drift_has_died_away() {
    // 20 µm off at arrival, time constant 0.4 s
    let reading = |_: f64, since: f64, _: f64| [0.02 * (-since.max(0.0) / 0.4).exp(), 0.0, 0.0];
    let steps = Shop { legs: &legs(&[0.0, 0.5], 4.0), reading: &reading, noise_mm: 0.1e-3 }.run();
    let events = play(&mut cycle(&[0.0, 0.5]), &steps);
    assert_eq!(qualities(&events), [Good, Good]);
    // halves of a window differ by 2·sinh(0.125/0.4) times its median: 0.5 µm of drift is a median of 0.79 µm
    for point in points(&events) {
        assert!((0.5e-3..0.85e-3).contains(&point.reading_mm[0]), "{point:?}");
    }
}

#[test]
fn what_never_settles_or_is_left_early_is_marked_and_kept() {
    let noisy = |_: f64, _: f64, c: f64| if c > 0.7 { [0.0; 3] } else { [0.01, 0.0, 0.0] };
    // The second pose is left after 0.4 s, less than a window.
    let way = [
        Leg { c_rad: 0.0, stand_s: 1.5 },
        Leg { c_rad: 0.5, stand_s: 0.4 },
        Leg { c_rad: 1.0, stand_s: 1.5 },
    ];
    let steps = Shop { legs: &way, reading: &noisy, noise_mm: 0.1e-3 }.run();
    let events = play(&mut cycle(&[0.0, 0.5, 1.0]), &steps);
    assert_eq!((qualities(&events), end(&events)), (vec![Good, Unsettled, Good], EndReason::Complete));
    assert!((points(&events)[1].reading_mm[0] - 0.01).abs() < 1e-4);

    let shaking = Shop { legs: &legs(&[0.0, 0.5], 4.0), reading: &noisy, noise_mm: 5e-3 }.run();
    let events = play(&mut cycle(&[0.0, 0.5]), &shaking);
    assert_eq!(qualities(&events), [Unsettled, Unsettled]);
    assert!(points(&events).iter().all(|point| point.samples > 400 && point.spread_mm[0] > 3e-3));
}

#[test]
fn indicators_that_are_read_slowly_are_read_at_rest() {
    let reading = |_: f64, _: f64, c: f64| [0.01 * c, -0.02, 0.03];
    let check = |probe_ms: u32, stand_s: f64| {
        let stations = [0.0, 0.5, 1.0];
        let shop = Shop { legs: &legs(&stations, stand_s), reading: &reading, noise_mm: 0.1e-3 };
        let events = play(&mut cycle(&stations), &shop.read_every(probe_ms));
        assert_eq!(qualities(&events), [Good; 3], "every {probe_ms} ms");
        for (point, c) in points(&events).iter().zip(stations) {
            assert!((point.reading_mm[0] - 0.01 * c).abs() < 0.2e-3, "every {probe_ms} ms: {point:?}");
            assert!(point.samples >= 5 && point.spread_mm[0] > 0.0, "every {probe_ms} ms: {point:?}");
        }
    };
    [20, 49, 50, 60, 100, 200].into_iter().for_each(|probe_ms| check(probe_ms, 2.0));
    [500, 1000, 2000].into_iter().for_each(|probe_ms| check(probe_ms, 9e-3 * f64::from(probe_ms)));
}

#[test]
fn poses_passed_by_get_points_without_reading() {
    let steps =
        Shop { legs: &legs(&[0.0, 1.0, 1.5], 1.5), reading: &|_, _, _| [0.0; 3], noise_mm: 0.0 }.run();
    let events = play(&mut cycle(&[0.0, 0.25, 0.5, 1.0, 1.5, 2.0]), &steps);
    let [passed, end_of_cycle] = [Lacks::Dwell, Lacks::End].map(NoReading);
    assert_eq!(qualities(&events), [Good, passed, passed, Good, Good, end_of_cycle]);
    assert_eq!(end(&events), EndReason::Stopped);
    assert!(points(&events)[1].reading_mm[0].is_nan());
}

#[test]
fn a_missing_probe_inside_a_stand_delays_the_point_and_a_dead_one_leaves_it_without_reading() {
    // Channel 1 is away for 0.3 s in the middle of the first window, channel 1 for good at the second pose.
    let reading = |_: f64, since: f64, c: f64| {
        let away = c < 0.1 && (0.2..0.5).contains(&since) || c > 0.4;
        [0.001, if away { f64::NAN } else { 0.002 }, 0.003]
    };
    let steps = Shop { legs: &legs(&[0.0, 0.5], 4.0), reading: &reading, noise_mm: 0.0 }.run();
    let events = play(&mut cycle(&[0.0, 0.5]), &steps);
    assert_eq!(qualities(&events), [Good, NoReading(Lacks::Value)]);
    let first = &points(&events)[0];
    assert_eq!(first.reading_mm, [0.001, 0.002, 0.003]);
    // The stand begins at 0.4 s, the probe is back at 0.9 s: the window lies behind.
    assert!(first.state.time_s.unwrap() > 1.1, "{first:?}");
}

#[test]
fn where_the_grid_turns_back_one_stand_gives_two_points_from_windows_of_their_own() {
    let stations = [0.0, 0.5, 0.5, 0.0];
    let reading = |t: f64, _: f64, _: f64| [1e-4 * t, 0.0, 0.0];
    let once = Shop { legs: &legs(&[0.0, 0.5, 0.0], 2.0), reading: &reading, noise_mm: 0.0 }.run();
    let events = play(&mut cycle(&stations), &once);
    assert_eq!((qualities(&events), end(&events)), (vec![Good; 4], EndReason::Complete));
    let times: Vec<f64> = points(&events).iter().map(|point| point.state.time_s.unwrap()).collect();
    assert!(times[2] - times[1] >= 0.5, "{times:?}");

    // A program that overruns and comes back from the other side: the later reading counts.
    let way = [(0.0, 2.0), (0.5, 2.0), (0.7, 0.3), (0.5, 2.0), (0.0, 2.0)]
        .map(|(c_rad, stand_s)| Leg { c_rad, stand_s });
    let events = play(&mut cycle(&stations), &Shop { legs: &way, reading: &reading, noise_mm: 0.0 }.run());
    assert_eq!(qualities(&events), [Good; 4]);
    let directions: Vec<f64> = points(&events).iter().map(|point| point.state.direction[C]).collect();
    assert_eq!(directions, [1.0, 1.0, -1.0, -1.0]);
}

#[test]
fn coming_back_to_a_pose_already_read_is_no_jump_to_a_later_pass() {
    let stations = [0.0, 0.5, 1.0, 0.5, 0.0];
    let way = [0.0, 0.2, 0.0, 0.5, 1.0, 0.5, 0.0];
    let steps = Shop { legs: &legs(&way, 1.5), reading: &|_, _, _| [0.0; 3], noise_mm: 0.0 }.run();
    let events = play(&mut cycle(&stations), &steps);
    assert_eq!(qualities(&events), [Good; 5]);
    assert!(events.iter().any(|event| matches!(event, CycleEvent::UnknownDwell { .. })));
}

#[test]
fn a_machine_that_stops_for_good_ends_the_cycle_and_progress_reports_the_time_left() {
    let stations = [0.0, 0.5, 1.0, 1.5];
    let way = [(0.0, 1.6), (0.5, 1.6), (1.0, 6.0)].map(|(c_rad, stand_s)| Leg { c_rad, stand_s });
    let steps = Shop { legs: &way, reading: &|_, _, _| [0.0; 3], noise_mm: 0.0 }.run();
    let rules = StaticRules { end_after_still_s: 4.0, ..StaticRules::new(SETTLE) };
    let mut cycle = StaticCycle::new(poses(&stations), rules, vec![], vec![C], 0);
    let mut events = Vec::new();
    steps.iter().for_each(|step| cycle.push(step, &mut events));
    assert_eq!(
        (qualities(&events), end(&events)),
        (vec![Good, Good, Good, NoReading(Lacks::End)], EndReason::NoMotion)
    );

    let mut again = StaticCycle::new(poses(&stations), rules, vec![], vec![C], 0);
    let third = steps.iter().position(|step| {
        again.push(step, &mut Vec::new());
        again.progress().done == 3
    });
    assert!(third.is_some());
    let left = again.progress().seconds_left.unwrap();
    assert!((1.9..2.1).contains(&left), "{left}"); // one pose, 2 s each
}

#[test]
fn the_same_samples_give_the_same_bytes() {
    let reading = |t: f64, since: f64, c: f64| [c * 0.01 + 0.001 * (7.0 * t).sin(), 1e-3 * since, 0.0];
    let steps = Shop { legs: &legs(&[0.0, 0.5, 1.0], 2.0), reading: &reading, noise_mm: 0.3e-3 }.run();
    let once = format!("{:?}", play(&mut cycle(&[0.0, 0.5, 1.0]), &steps));
    assert_eq!(once, format!("{:?}", play(&mut cycle(&[0.0, 0.5, 1.0]), &steps)));
}
