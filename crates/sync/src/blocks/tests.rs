use super::*;
use std::f64::consts::TAU;
use trunnion_core::Quality;
use trunnion_core::axis::iso::{C, X, Y};

/// Both ways round C at `step_rad`, X and Y following on radius 100 mm; readings `kinematic(state) + error(state, i)`.
fn sweep(samples: usize, feed: f64, error: impl Fn(&State, usize) -> f64) -> Vec<Point> {
    let step = TAU / samples as f64;
    let mut points = Vec::new();
    for direction in [1.0, -1.0] {
        for i in 0..samples {
            let travelled = (i as f64 + 0.5) * step;
            let c = if direction > 0.0 { travelled } else { TAU - travelled };
            let mut state = State { time_s: Some(points.len() as f64 * step / feed), ..State::default() };
            (state.position[C], state.position[X], state.position[Y]) = (c, 100.0 * c.cos(), 100.0 * c.sin());
            let omega = feed * direction;
            (state.velocity[C], state.velocity[X], state.velocity[Y]) =
                (omega, -100.0 * omega * c.sin(), 100.0 * omega * c.cos());
            (state.acceleration[X], state.acceleration[Y]) =
                (-100.0 * feed * feed * c.cos(), -100.0 * feed * feed * c.sin());
            state.direction = AxisValues(state.velocity.0.map(|v| if v == 0.0 { 0.0 } else { v.signum() }));
            state.since_reversal[C] = travelled;
            // |cos| turns at 0 and π, |sin| at ½π and 1½π
            state.since_reversal[X] = 100.0 * (1.0 - c.cos().abs());
            state.since_reversal[Y] = 100.0 * (1.0 - c.sin().abs());
            let value = nominal(&state)[0] + error(&state, points.len());
            points.push(Point { reading_mm: [value, 0.0, 0.0], ..blank(state) });
        }
    }
    points
}

fn blank(state: State) -> Point {
    Point { state, reading_mm: [0.0; 3], spread_mm: [0.0; 3], samples: 0, quality: Quality::Good }
}

/// A strongly curved nominal reading, as of a ball bar.
fn nominal(state: &State) -> [f64; 3] {
    [(state.position[X] - 30.0).hypot(state.position[Y]) - 80.0, 0.0, 0.0]
}

fn reduce(points: &[Point], most_blocks: usize) -> Reduction {
    reduce_from(points, most_blocks, nominal)
}

fn reduce_from(points: &[Point], most_blocks: usize, nominal: impl Fn(&State) -> [f64; 3]) -> Reduction {
    let mut reducer = Reducer::new(Limits { most_blocks, ..Limits::default() }, nominal);
    for (index, point) in (0..).zip(points) {
        reducer.push(index, point.clone());
    }
    reducer.finish()
}

/// White noise of standard deviation 1, the same every time.
fn white(i: usize) -> f64 {
    let mut x = i as u64 ^ 0x9E37_79B9_7F4A_7C15;
    let mut uniform = || {
        x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = x;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let (a, b) = (uniform().max(1e-12), uniform());
    (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
}

fn departures(reduction: &Reduction) -> impl Iterator<Item = (&Point, f64)> {
    reduction.points.iter().map(|point| (point, point.reading_mm[0] - nominal(&point.state)[0]))
}

#[test]
fn a_curved_nominal_reading_leaves_no_trace_and_the_state_lies_on_the_path() {
    let reduction = reduce(&sweep(40_000, 0.5, |_, _| 0.0), 400);
    assert!((200..=400).contains(&reduction.points.len()), "{}", reduction.points.len());
    assert_eq!(reduction.samples, 80_000);
    assert_eq!(reduction.points.iter().map(|p| u64::from(p.samples)).sum::<u64>(), 80_000);
    for (point, departure) in departures(&reduction) {
        assert!(departure.abs() < 1e-12, "{departure}");
        let radius = point.state.position[X].hypot(point.state.position[Y]);
        assert!((radius - 100.0).abs() < 5e-6, "{radius}");
    }
}

#[test]
fn sixty_lobes_survive_blocks_of_two_degrees_as_the_header_says() {
    let lobes = |n: f64| sweep(40_000, 0.5, move |state, _| 1e-3 * (n * state.position[C]).sin());
    for (n, at_least) in [(10.0, 0.9995), (30.0, 0.99), (60.0, 0.9)] {
        let reduction = reduce(&lobes(n), 800);
        assert!(reduction.width_units <= 2.0 + 1e-9, "{}", reduction.width_units);
        let (mut product, mut square) = (0.0, 0.0);
        for (point, departure) in departures(&reduction) {
            let shape = 1e-3 * (n * point.state.position[C]).sin();
            product += shape * departure;
            square += shape * shape;
        }
        assert!((at_least..1.001).contains(&(product / square)), "{n}: {}", product / square);
    }
}

#[test]
fn a_reversal_spike_keeps_its_height_and_its_decay() {
    let spike = |state: &State| -5e-3 * state.direction[X] * (-state.since_reversal[X] / 0.3).exp();
    let truth = sweep(100_000, 0.5, |state, _| {
        // Travel since the reversal only after it: before it the axis has come a long way.
        let after = state.position[X] * state.velocity[X] < 0.0;
        if after { spike(state) } else { 0.0 }
    });
    let points: Vec<Point> = truth
        .into_iter()
        .map(|mut point| {
            if point.state.position[X] * point.state.velocity[X] > 0.0 {
                point.state.since_reversal[X] = 200.0 - point.state.since_reversal[X];
            }
            point
        })
        .collect();
    let reduction = reduce(&points, 1000);
    let worst =
        departures(&reduction).map(|(point, found)| (found - spike(&point.state)).abs()).fold(0.0, f64::max);
    assert!(worst < 0.2e-3, "{worst}");
    let highest = departures(&reduction).map(|(_, found)| found.abs()).fold(0.0, f64::max);
    assert!(highest > 4.7e-3, "{highest}");
}

#[test]
fn the_standard_error_is_what_blocks_really_scatter_also_when_samples_are_correlated() {
    for correlation in [0.0, 0.9] {
        let mut state_of_noise = 0.0;
        let noise: Vec<f64> = (0..160_000)
            .map(|i| {
                state_of_noise =
                    correlation * state_of_noise + (1.0_f64 - correlation * correlation).sqrt() * white(i);
                0.3e-3 * state_of_noise
            })
            .collect();
        let reduction = reduce(&sweep(80_000, 0.5, |_, i| noise[i]), 400);
        let relative: Vec<f64> = departures(&reduction).map(|(p, d)| d / p.standard_error_mm()[0]).collect();
        let rms = (relative.iter().map(|r| r * r).sum::<f64>() / relative.len() as f64).sqrt();
        assert!((0.85..1.25).contains(&rms), "{correlation}: {rms}");
        // What averaging took away is counted: the octaves and what is left add up to the noise.
        let pass = &reduction.passes[0];
        let removed: f64 = pass.bands.iter().map(|band| band.rms_mm[0].powi(2)).sum();
        assert!((removed.sqrt() - 0.3e-3).abs() < 0.02e-3, "{}", removed.sqrt());
    }
}

#[test]
fn single_outliers_are_excluded_and_counted_and_a_step_is_kept() {
    let mut points =
        sweep(20_000, 0.5, |state, i| 0.1e-3 * white(i) + if state.position[C] > 3.0 { 8e-3 } else { 0.0 });
    for i in (500..40_000).step_by(1000) {
        points[i].reading_mm[0] += 20e-3;
    }
    points[777].reading_mm[2] = f64::NAN;
    let reduction = reduce(&points, 400);
    assert_eq!((reduction.excluded, reduction.missing), (40, 1));
    assert_eq!(reduction.passes.iter().map(|pass| pass.excluded).sum::<u64>(), 40);
    for (point, departure) in departures(&reduction) {
        let c = point.state.position[C];
        let expected = if c > 3.0 { 8e-3 } else { 0.0 };
        assert!((departure - expected).abs() < 0.1e-3 || (c - 3.0).abs() < 0.15, "{c} {departure}");
    }
}

/// Every kind of noise and phase of the tests below.
const SEEDS: [usize; 4] = [0, 1_000_000, 2_000_000, 3_000_000];

/// Neighbours that differ more than the noise says nothing against a sample of a smooth motion, or beside a corner of it.
#[test]
fn a_smooth_motion_loses_no_sample_however_small_its_noise() {
    for (seed, turns) in SEEDS.iter().flat_map(|seed| [3.0, 40.0, 200.0, 1000.0].map(|turns| (seed, turns))) {
        for noise_mm in [1e-7, 5e-5, 2e-4] {
            let phase = TAU * white(*seed);
            let teeth = |state: &State, i: usize| {
                let share = ((turns * state.position[C] + phase) / TAU).rem_euclid(1.0);
                5e-3 * (2.0 * share - 1.0).abs() + noise_mm * white(seed + i)
            };
            let wave = |state: &State, i: usize| {
                5e-3 * (turns * state.position[C] + phase).sin() + noise_mm * white(seed + i)
            };
            let lost = [reduce(&sweep(20_000, 0.5, teeth), 400), reduce(&sweep(20_000, 0.5, wave), 400)]
                .map(|reduction| reduction.excluded);
            assert_eq!(lost, [0, 0], "{turns} {noise_mm} {seed}");
        }
    }
}

/// A lone change of a display is its step, not the noise of the probe; a chip is more than that.
#[test]
fn a_coarse_display_loses_the_lone_readings_and_no_other() {
    let cases = [(0.02, 3.0, 40_000), (0.2, 3.0, 40_000), (1.0, 40.0, 40_000), (0.2, 3.0, 400)];
    for (seed, step_mm) in SEEDS.iter().flat_map(|seed| [5e-4, 1e-3, 2e-3].map(|step_mm| (seed, step_mm))) {
        for (share_of_noise, turns, every) in cases {
            let shown = |mm: f64| (mm / step_mm).round() * step_mm;
            let wave = |state: &State, i: usize| {
                let noise_mm = share_of_noise * step_mm * white(seed + i);
                5e-3 * (turns * state.position[C]).sin() + noise_mm
            };
            let mut bar = sweep(20_000, 0.5, wave);
            let lone = bar.iter_mut().skip(every).step_by(every);
            let lone = lone.map(|point| point.reading_mm[0] += 40e-3).count() as u64;
            let mut probe = bar.clone();
            for (bar, probe) in bar.iter_mut().zip(&mut probe) {
                probe.reading_mm[0] = shown(probe.reading_mm[0] - nominal(&probe.state)[0]);
                bar.reading_mm[0] = shown(bar.reading_mm[0]);
            }
            let lost = [reduce(&bar, 400), reduce_from(&probe, 400, |_| [0.0; 3])]
                .map(|reduction| reduction.excluded);
            assert_eq!(lost, [lone, lone], "{step_mm} {share_of_noise} {seed}");
        }
    }
}

#[test]
fn two_equal_in_a_row_are_excluded_and_three_are_kept() {
    let base = |seed: usize| sweep(20_000, 0.5, move |_, i| 0.1e-3 * white(seed + i));
    for (seed, (equal, excluded)) in
        SEEDS.iter().flat_map(|seed| [(1, 40), (2, 80), (3, 0), (6, 0)].map(|case| (seed, case)))
    {
        let mut points = base(*seed);
        for first in (500..40_000).step_by(1000) {
            points[first..first + equal].iter_mut().for_each(|point| point.reading_mm[0] += 5e-3);
        }
        assert_eq!(reduce(&points, 400).excluded, excluded, "{equal} {seed}");
    }
}

#[test]
fn two_setups_mixed_sample_by_sample_give_the_same_blocks_as_one_after_the_other() {
    let one = sweep(5000, 0.5, |state, i| 1e-3 * state.position[C].sin() + 1e-4 * white(i));
    let other: Vec<Point> = one
        .iter()
        .map(|point| Point { state: State { setup: 1, ..point.state.clone() }, ..point.clone() })
        .collect();
    let mixed: Vec<Point> = one.iter().zip(&other).flat_map(|(a, b)| [a.clone(), b.clone()]).collect();
    let apart: Vec<Point> = one.into_iter().chain(other).collect();
    let of_setup = |reduction: &Reduction, setup| -> Vec<[f64; 3]> {
        let points = reduction.points.iter().filter(|point| point.state.setup == setup);
        points.map(|point| point.reading_mm).collect()
    };
    // No merging: the limit is far above what the finest width gives.
    let (mixed, apart) = (reduce(&mixed, 20_000), reduce(&apart, 20_000));
    for setup in [0, 1] {
        assert!(of_setup(&mixed, setup) == of_setup(&apart, setup), "setup {setup}");
    }
}

#[test]
fn directions_that_flicker_do_not_break_the_limit() {
    let mut points = sweep(50_000, 0.5, |_, i| 1e-4 * white(i));
    for (i, point) in points.iter_mut().enumerate() {
        point.state.direction[X] = if white(i ^ 0x55) > 0.0 { 1.0 } else { -1.0 };
    }
    let reduction = reduce(&points, 400);
    assert!(reduction.points.len() <= 400, "{}", reduction.points.len());
    assert_eq!(reduction.points.iter().map(|p| u64::from(p.samples)).sum::<u64>(), 100_000);
}
