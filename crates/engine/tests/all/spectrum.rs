//! Waves of any period along an axis are found with an honest uncertainty, and none where nothing waves.

use crate::common::{point, points_run, run};
use nalgebra::{Point3, Vector3};
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;
use trunnion_core::axis::iso::{C, X};
use trunnion_core::{AxisValues, InstrumentKind, NestSide, Setup, State};
use trunnion_effects::Model;
use trunnion_engine::spectrum::{AxisSpectrum, spectra};
use trunnion_engine::{Experiment, Problem, diagnose};
use trunnion_machine::shipped;

const WHITE_UM: f64 = 0.3;
/// Drift along the path next to the white noise: neighbours err alike.
const DRIFT_UM: f64 = 0.5;

struct Line {
    step_mm: f64,
    even: bool,
    period_mm: f64,
    amplitude_um: f64,
}

/// The spectrum of X along a laser line of 300 readings.
fn along_a_line(line: &Line, random: &mut ChaCha8Rng) -> AxisSpectrum {
    let machine = shipped::machine("three-axis").unwrap();
    let mut setup = Setup::new("line", InstrumentKind::Diagonal, NestSide::Table, Point3::new(0.0, 0.0, 0.0));
    setup.direction = Some(Vector3::x_axis());
    let phase = random.random_range(0.0..TAU);
    let mut drift = 0.0;
    let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
    let points = (0..300)
        .map(|i| {
            let off = if line.even { 0.0 } else { random.random_range(-0.45..0.45) };
            let x = line.step_mm * (f64::from(i) + off);
            drift = 0.97 * drift + (1.0_f64 - 0.97 * 0.97).sqrt() * DRIFT_UM * normal(random);
            let wave = line.amplitude_um * (TAU * x / line.period_mm + phase).sin();
            let reading_mm = x + 1e-3 * (wave + drift + WHITE_UM * normal(random));
            let mut position = AxisValues::default();
            position[X] = x;
            let time_s = Some(f64::from(i));
            point(State { position, time_s, ..State::default() }, [reading_mm, 0.0, 0.0])
        })
        .collect();
    let experiment = Experiment::new(&[run("line", machine, vec![setup], points)]).unwrap();
    let problem = Problem::new(&experiment, &Model::base(&experiment.machine().name)).unwrap();
    spectra(&problem).unwrap().into_iter().find(|spectrum| spectrum.joint == X).unwrap()
}

#[test]
fn a_wave_of_any_period_is_found_with_its_uncertainty() {
    let mut random = ChaCha8Rng::seed_from_u64(20);
    let (mut within_2u, mut count) = (0, 0);
    for trial in 0..40 {
        let step_mm = 10f64.powf(random.random_range(-2.0..0.0));
        let period_mm = step_mm * 10f64.powf(random.random_range(0.5..1.7));
        let line = Line { step_mm, even: trial % 2 == 0, period_mm, amplitude_um: 1.5 };
        let spectrum = along_a_line(&line, &mut random);
        let wave = spectrum
            .waves
            .first()
            .unwrap_or_else(|| panic!("no wave of {period_mm} mm at steps of {step_mm} mm"));
        let off = (wave.value - period_mm).abs() / wave.u;
        assert!(off < 5.0, "{} ± {} mm for {period_mm}", wave.value, wave.u);
        within_2u += usize::from(off < 2.0);
        count += 1;
        let amplitude_um = wave.amplitude.unwrap();
        assert!((amplitude_um - 1.5).abs() < 0.35, "{amplitude_um} µm for 1.5");
        assert_eq!(wave.alias.is_some(), line.even, "an even grid has an alias, an uneven one has none");
    }
    assert!(within_2u * 100 >= 85 * count, "{within_2u} of {count} within 2 u");
}

#[test]
fn noise_that_wanders_is_no_wave() {
    let mut random = ChaCha8Rng::seed_from_u64(21);
    let line = |even| Line { step_mm: 0.1, even, period_mm: 1.0, amplitude_um: 0.0 };
    let falsely =
        (0..60).filter(|trial| !along_a_line(&line(trial % 2 == 0), &mut random).waves.is_empty()).count();
    // One in twenty by the price; five of sixty are exceeded once in fifty such tests.
    assert!(falsely <= 6, "{falsely} of 60 empty lines wave");
}

/// An R-test on B-C at B = 0: the ball moves along the axis of C by the wave, µm and cycles a turn, at even stations both ways.
fn round_c(step_deg: f64, cycles: f64, amplitude_um: f64) -> AxisSpectrum {
    let machine = shipped::machine("table-bc").unwrap();
    let ball = Point3::new(150.0, 0.0, 60.0);
    let setup = Setup::new("ball", InstrumentKind::RTest, NestSide::Table, ball);
    let mut random = ChaCha8Rng::seed_from_u64(22);
    let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
    let stations = (360.0 / step_deg).round() as i32;
    let there: Vec<f64> = (0..stations).map(|i| (step_deg * f64::from(i)).to_radians()).collect();
    let passes = there.iter().map(|c| (*c, 1.0)).chain(there.iter().rev().map(|c| (*c, -1.0)));
    let points = passes
        .map(|(c, direction)| {
            let mut position = AxisValues::default();
            position[C] = c;
            let mut position = machine.follow(&position, &ball).unwrap();
            position[C] = c;
            let mut state = State { position, ..State::default() };
            state.direction[C] = direction;
            let mut reading_mm = [0.0; 3].map(|_| 1e-3 * 0.1 * normal());
            reading_mm[2] += 1e-3 * amplitude_um * (cycles * c + 0.4).sin();
            point(state, reading_mm)
        })
        .collect();
    let experiment = Experiment::new(&[run("c", machine, vec![setup], points)]).unwrap();
    let problem = Problem::new(&experiment, &Model::base(&experiment.machine().name)).unwrap();
    spectra(&problem).unwrap().into_iter().find(|spectrum| spectrum.joint == C).unwrap()
}

#[test]
fn a_wave_at_a_broken_number_per_turn_is_found_and_has_no_whole_name() {
    let spectrum = round_c(5.0, 7.3, 3.0);
    let wave = &spectrum.waves[0];
    assert_eq!(wave.unit, "per turn");
    assert!((wave.value - 7.3).abs() < 5.0 * wave.u && wave.u < 0.05, "{wave:?}");
    assert_eq!(wave.is, None, "{wave:?}");
    let whole = round_c(5.0, 7.0, 3.0);
    assert_eq!(whole.waves[0].is.as_deref(), Some("7 per turn"), "{:?}", whole.waves[0]);
}

#[test]
fn on_a_grid_of_30_degrees_n_and_12_minus_n_give_the_same_readings_and_both_are_said() {
    for cycles in [5.0, 7.0] {
        let mut run = points_run("points-nothing-hidden");
        for point in &mut run.points {
            // Along the circle that C carries the ball on: a positioning error of C.
            point.reading_mm[1] += 1e-3 * 2.0 * (cycles * point.state.position[C] + 0.4).sin();
        }
        let experiment = Experiment::new(&[run]).unwrap();
        let diagnosis = diagnose(&experiment, &Model::base("table-bc"), &Default::default()).unwrap();
        let wave = diagnosis.candidates.iter().find_map(|c| c.period.as_ref()).unwrap();
        let found = (wave.value, wave.alias.unwrap());
        assert!((found.0 - 5.0).abs() < 0.05 && (found.1 - 7.0).abs() < 0.05, "{wave:?}");
    }
}

#[test]
fn few_positions_have_no_background_and_are_not_judged() {
    // Twelve stations know no more than six whole numbers per turn.
    let few = round_c(30.0, 3.0, 12.0);
    assert!(few.waves.is_empty() && !few.judged, "{few:?}");
    let many = round_c(5.0, 3.0, 0.0);
    assert!(many.waves.is_empty() && many.judged, "{many:?}");
}
