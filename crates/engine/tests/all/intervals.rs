//! 95 % intervals hold the truth in about 95 % of runs, whether the noise is white or drifts.
//!
//! A perfect machine is measured many times; the readings are noise alone, drawn here from its definition: white, plus an
//! Ornstein–Uhlenbeck drift `x ← a x + √(1 − a²) σ ξ`, `a = exp(−Δt/τ)`, along the machine axes in which a nest in the spindle reads.
//! Every true location error is zero.

use crate::common;
use nalgebra::{Point3, Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::axis::iso::{B, C};
use trunnion_core::{AxisValues, InstrumentKind, Joint, NestSide, Point, Setup, State};
use trunnion_cycles::Run;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::fit::Options;
use trunnion_engine::fit::doubts::{Doubt, DoubtReason, doubts};
use trunnion_engine::{Experiment, HeldOut, Uncertainties, identify};
use trunnion_machine::shipped;

const DRAWS: usize = 200;
const WHITE_MM: f64 = 0.3e-3;
const STEP_S: f64 = 5.0;
/// Half-width of a 95 % interval of the normal distribution.
const WIDE: f64 = 1.96;
/// Draws are independent: the share of 200 that hold has a standard deviation of √(0.95 · 0.05/200) = 0.0154.
const SPREAD: f64 = 0.0154;

#[derive(Clone, Copy)]
struct Drift {
    sigma_mm: f64,
    tau_s: f64,
}

const NONE: Drift = Drift { sigma_mm: 0.0, tau_s: 1.0 };
const SLOW: Drift = Drift { sigma_mm: 0.25e-3, tau_s: 150.0 };

/// Two heights, B −60…60° and C 0…300°, there and back: 120 points in ten minutes.
fn cycle() -> Run {
    let machine = shipped::machine("table-bc").expect("shipped");
    let setup = |name: &str, z: f64| {
        Setup::new(name, InstrumentKind::RTest, NestSide::Spindle, Point3::new(150.0, 0.0, z))
    };
    let setups = vec![setup("low", 60.0), setup("high", 160.0)];
    let there: Vec<(i32, i32)> = (-2..=2).flat_map(|b| (0..6).map(move |c| (b, c))).collect();
    let back = there.iter().rev().map(|&pose| (pose, -1.0));
    let both: Vec<_> = there.iter().map(|&pose| (pose, 1.0)).chain(back).collect();
    let mut points: Vec<Point> = Vec::new();
    for (i, placed) in setups.iter().enumerate() {
        for &((b, c), direction) in &both {
            let mut rotary = AxisValues::default();
            rotary[B] = f64::from(30 * b).to_radians();
            rotary[C] = f64::from(60 * c).to_radians();
            let position = machine.follow(&rotary, &placed.ball_in_table_mm).expect("within travel");
            let time_s = Some(STEP_S * points.len() as f64);
            let mut state = State { position, time_s, setup: i, ..State::default() };
            (state.direction[B], state.direction[C]) = (direction, direction);
            points.push(common::point(state, [0.0; 3]));
        }
    }
    common::run("noise", machine, setups, points)
}

/// The same readings of the same machine by a nest that turns with the table: R_C(−c) R_B(−b) of what a nest in the spindle reads.
fn in_the_table(mut run: Run) -> Run {
    for setup in &mut run.setups {
        setup.nest = NestSide::Table;
    }
    for point in &mut run.points {
        let about = |axis: &Vector3<f64>, joint: Joint| {
            Rotation3::from_scaled_axis(axis * -point.state.position[joint])
        };
        let turn = about(&Vector3::z(), C) * about(&Vector3::y(), B);
        point.reading_mm = (turn * Vector3::from(point.reading_mm)).into();
    }
    run
}

/// Readings with offsets of this size (mm) that a pass, one direction of a setup, has in common.
fn with_offsets(mut run: Run, sigma_mm: f64, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x5EED);
    let mut offset = || [0.0; 3].map(|_: f64| sigma_mm * rng.sample::<f64, _>(StandardNormal));
    let of_pass = |point: &Point| (point.state.setup, point.state.direction[C] > 0.0);
    let (mut last, mut offset_mm) = (None, [0.0; 3]);
    for point in &mut run.points {
        if last.replace(of_pass(point)) != Some(of_pass(point)) {
            offset_mm = offset();
        }
        point
            .reading_mm
            .iter_mut()
            .zip(&offset_mm)
            .for_each(|(reading_mm, offset_mm)| *reading_mm += offset_mm);
    }
    run
}

/// One of the machines that docs/design/statistics.md §1.1 and §1.3 expect: it has offsets of passes or not, and drift or not, one to one each;
/// sizes e^N(ln 0.25, 1.2²) and e^N(ln 0.15, 1.2²) of the white noise; a correlation time between four points and the whole run.
fn expected(cycle: &Run, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0xE4);
    let mut size_mm = |usual: f64| {
        let (has_it, ln): (bool, f64) = (rng.random(), rng.sample(StandardNormal));
        if has_it { WHITE_MM * usual * (1.2 * ln).exp() } else { 0.0 }
    };
    let (offsets_mm, drift_mm) = (size_mm(0.25), size_mm(0.15));
    let shortest_s = 4.0 * STEP_S;
    let longest_s = STEP_S * cycle.points.len() as f64;
    let tau_s = shortest_s * (longest_s / shortest_s).powf(rng.random());
    with_offsets(draw(cycle, Drift { sigma_mm: drift_mm, tau_s }, seed), offsets_mm, seed)
}

fn draw(cycle: &Run, drift: Drift, seed: u64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut run = cycle.clone();
    let kept = (-STEP_S / drift.tau_s).exp();
    let mut drifted_mm = [0.0; 3].map(|_: f64| drift.sigma_mm * normal());
    for point in &mut run.points {
        for (reading_mm, drifted_mm) in point.reading_mm.iter_mut().zip(&mut drifted_mm) {
            *reading_mm = *drifted_mm + WHITE_MM * normal();
            *drifted_mm = kept * *drifted_mm + (1.0 - kept * kept).sqrt() * drift.sigma_mm * normal();
        }
    }
    run
}

/// Share of the draws in which the interval of each location error holds zero, and rms of error over u.
fn cover(drift: Drift, uncertainties: Uncertainties) -> Vec<(String, f64, f64)> {
    cover_of(|cycle, seed| draw(cycle, drift, seed), uncertainties)
}

fn cover_of(drawn: impl Fn(&Run, u64) -> Run, uncertainties: Uncertainties) -> Vec<(String, f64, f64)> {
    let cycle = cycle();
    let options = Options { holdout: HeldOut::Skipped, uncertainties, ..Options::default() };
    let mut pulls: Vec<(String, Vec<f64>)> = Vec::new();
    for seed in 0..DRAWS as u64 {
        let experiment = Experiment::new(&[drawn(&cycle, seed)]).expect("points");
        let fit = identify(&experiment, &Model::base("table-bc"), &options).expect("a fit");
        let numbers = fit.parameters.iter().filter(|p| p.effect == "location-errors");
        for parameter in numbers {
            let (Some(value), Some(u)) = (parameter.value, parameter.u) else { continue };
            match pulls.iter_mut().find(|(name, _)| *name == parameter.name) {
                Some((_, pulls)) => pulls.push(value / u),
                None => pulls.push((parameter.name.clone(), vec![value / u])),
            }
        }
    }
    let share = |pulls: &[f64]| pulls.iter().filter(|pull| pull.abs() <= WIDE).count() as f64 / DRAWS as f64;
    let rms = |pulls: &[f64]| (pulls.iter().map(|pull| pull * pull).sum::<f64>() / pulls.len() as f64).sqrt();
    pulls.into_iter().map(|(name, pulls)| (name, share(&pulls), rms(&pulls))).collect()
}

fn mean(covered: &[(String, f64, f64)]) -> f64 {
    covered.iter().map(|(_, share, _)| share).sum::<f64>() / covered.len() as f64
}

/// `too_wide`: parameters whose u is known to be larger than it need be; errors are at least this share of it.
fn check(drift: Drift, (too_wide, least): (&[&str], f64)) {
    let covered = cover(drift, Uncertainties::NoiseParts);
    println!("{covered:.3?}");
    assert_eq!(covered.len(), 8, "the minimum set of location errors has numbers in every draw");
    for (name, share, rms_pull) in &covered {
        assert!(*share > 0.95 - 4.0 * SPREAD, "{name}: {share}");
        let narrowest = if too_wide.contains(&name.as_str()) { least } else { 0.75 };
        assert!((narrowest..1.25).contains(rms_pull), "{name}: errors are {rms_pull} of what u says");
    }
    assert!(mean(&covered) > 0.95 - 2.0 * SPREAD, "{}", mean(&covered));
    // Numbers that are known to be wide hold more.
    let fair: Vec<_> = covered.into_iter().filter(|(name, ..)| !too_wide.contains(&name.as_str())).collect();
    assert!((mean(&fair) - 0.95).abs() < 2.0 * SPREAD, "{}", mean(&fair));
}

#[test]
fn intervals_hold_the_truth_when_the_noise_is_white() {
    // Ten minutes do not exclude a drift of a seventh of the noise, and the prior expects one (docs/design/statistics.md §1.1): what an
    // offset moves most has a u that a machine without any drift does not need.
    check(NONE, (&["EX0B", "EZ0B", "EY0C"], 0.5));
}

#[test]
fn intervals_hold_the_truth_when_the_machine_drifts() {
    // Ten minutes do not exclude offsets of passes next to the drift: errors of EB0B and EA0C are 0.73 of what u says.
    check(SLOW, (&["EB0B", "EA0C"], 0.7));
    let covered = cover(SLOW, Uncertainties::Clusters);
    assert!(
        mean(&covered) < 0.95 - 6.0 * SPREAD,
        "clusters do not see drift that outlasts them: {covered:?}"
    );
}

/// Slow drift along the axes of the machine while the nest turns with the table looks like offsets of passes in the readings, and moves the
/// location errors more than those do. 120 poses in ten minutes do not show a drift of three minutes well, and this one is six times what is
/// expected of a machine beforehand: the three numbers that it moves most are held by 87 to 92 % of the intervals, with errors of up to 1.35 u.
#[test]
fn intervals_hold_the_truth_when_the_machine_drifts_and_the_nest_turns() {
    let offsets_mm = 0.12e-3;
    let drift = Drift { sigma_mm: 0.18e-3, tau_s: 200.0 };
    let drawn = |cycle: &Run, seed| with_offsets(in_the_table(draw(cycle, drift, seed)), offsets_mm, seed);
    let covered = cover_of(drawn, Uncertainties::NoiseParts);
    println!("{covered:.3?}");
    for (name, share, rms_pull) in &covered {
        assert!(
            *share > 0.9 - 4.0 * SPREAD && *rms_pull < 1.45,
            "{name}: {share}, errors are {rms_pull} of what u says"
        );
    }
    assert!((mean(&covered) - 0.95).abs() < 2.0 * SPREAD, "{}", mean(&covered));
}

/// The machines of which the prior is the distribution: a u that holds 95 % of the mixture of all sizes then holds 95 % of them, neither more nor
/// less, whatever it holds of those that have an offset or of those that have none.
#[test]
fn intervals_hold_the_truth_of_the_machines_that_the_prior_expects() {
    let covered = cover_of(expected, Uncertainties::NoiseParts);
    assert_eq!(covered.len(), 8);
    assert!((mean(&covered) - 0.95).abs() < 2.0 * SPREAD, "{} {covered:?}", mean(&covered));
}

#[test]
fn the_parts_of_the_noise_come_out_as_drawn() {
    let (mut white, mut drift) = (0.0, 0.0);
    for seed in 0..20 {
        let experiment = Experiment::new(&[draw(&cycle(), SLOW, seed)]).unwrap();
        let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
        let variance = |name: &str| -> f64 {
            fit.noise_parts.iter().filter(|part| part.name == name).map(|part| part.sigma_mm.powi(2)).sum()
        };
        white += variance("white") / 20.0;
        drift += (variance("drift") + variance("offsets of passes")) / 20.0;
    }
    assert!((white.sqrt() / WHITE_MM - 1.0).abs() < 0.05, "white {} mm", white.sqrt());
    assert!((drift.sqrt() / SLOW.sigma_mm - 1.0).abs() < 0.3, "drift and offsets {} mm", drift.sqrt());
}

/// A spindle that grows by 12 µm while it is measured, with time constants from a third of the run to once and a half of it: the longer ones are
/// not seen to their end, and what they leave open is part of the u of the growth.
#[test]
fn intervals_hold_a_growth_whose_time_constant_the_run_leaves_open() {
    const GROWTH_MM: f64 = 12e-3;
    let cycle = cycle();
    let duration_s = STEP_S * cycle.points.len() as f64;
    let mut model = Model::base("table-bc");
    model.effects.push(ModelEffect { id: "spindle-growth".into(), ..ModelEffect::default() });
    let options = Options { holdout: HeldOut::Skipped, ..Options::default() };
    let mut pulls = [Vec::new(), Vec::new()];
    for seed in 0..DRAWS as u64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x70);
        let tau_s = duration_s * rng.random_range(0.33..1.5);
        let mut run = draw(&cycle, if seed % 2 == 0 { NONE } else { SLOW }, seed);
        for point in &mut run.points {
            let elapsed_s = point.state.time_s.expect("stamped");
            // The nest in the spindle goes down with it, and the ball on the table is further up in it.
            point.reading_mm[2] += GROWTH_MM * (1.0 - (-elapsed_s / tau_s).exp());
        }
        let fit = identify(&Experiment::new(&[run]).expect("points"), &model, &options).expect("a fit");
        let growth = fit.parameter("growth").expect("of the model");
        let grown = fit.effects.last().expect("spindle growth");
        let tau_u = fit.shape_u(grown)[0].expect("found by the fit");
        pulls[0].push((growth.value.unwrap() - GROWTH_MM) / growth.u.unwrap());
        pulls[1].push((grown.shape[0] - tau_s) / tau_u);
    }
    for (name, pulls) in ["growth", "tau_s"].iter().zip(&pulls) {
        let share = pulls.iter().filter(|pull| pull.abs() <= WIDE).count() as f64 / DRAWS as f64;
        let rms = (pulls.iter().map(|pull| pull * pull).sum::<f64>() / DRAWS as f64).sqrt();
        assert!(share > 0.95 - 4.0 * SPREAD && (0.6..1.25).contains(&rms), "{name}: {share}, rms pull {rms}");
    }
}

/// One time constant leaves nothing for a second term to say: how the two share the drift hangs on chance, and is doubted. Two that are ten times
/// apart, both seen, are two numbers.
#[test]
fn terms_of_a_drift_that_the_readings_do_not_separate_are_doubted() {
    let cycle = cycle();
    let mut model = Model::base("table-bc");
    model.effects.push(ModelEffect { id: "thermal-drift".into(), ..ModelEffect::default() });
    let doubted = |terms: &[(f64, f64)], seed: u64| {
        let mut run = draw(&cycle, NONE, seed);
        for point in &mut run.points {
            let elapsed_s = point.state.time_s.expect("stamped");
            let of_term = |(final_mm, tau_s): &(f64, f64)| final_mm * (1.0 - (-elapsed_s / tau_s).exp());
            point.reading_mm[2] += terms.iter().map(of_term).sum::<f64>();
        }
        let experiment = Experiment::new(&[run]).expect("points");
        let fit = identify(&experiment, &model, &Options::default()).expect("a fit");
        let found = doubts(&experiment, &model, &fit);
        let is_it = |doubt: &&Doubt| matches!(doubt.reason, DoubtReason::TermsNotSeparated { .. });
        found.iter().find(is_it).is_some_and(|doubt| doubt.names.contains(&"z.2".to_string()))
    };
    for seed in 0..6 {
        assert!(doubted(&[(12e-3, 250.0)], seed), "one time constant, seed {seed}");
        assert!(!doubted(&[(40e-3, 40.0), (60e-3, 400.0)], seed), "two of them, seed {seed}");
    }
}

/// Times that begin again with the second setup are those of a clock of its own: how long after the first it was read, nobody knows, and little hangs
/// on it. Taken as one clock they would have both setups read in turn.
#[test]
fn a_clock_that_begins_again_with_a_setup_leaves_u_nearly_as_it_is() {
    let options = Options { holdout: HeldOut::Skipped, ..Options::default() };
    let fitted = |run: Run| {
        let experiment = Experiment::new(&[run]).expect("points");
        identify(&experiment, &Model::base("table-bc"), &options).expect("a fit")
    };
    let mut ln_ratios = Vec::new();
    for seed in 0..8 {
        let run = with_offsets(draw(&cycle(), SLOW, seed), 0.4e-3, seed);
        let mut again = run.clone();
        let begun_s =
            again.points.iter().find(|point| point.state.setup == 1).and_then(|p| p.state.time_s).unwrap();
        for point in again.points.iter_mut().filter(|point| point.state.setup == 1) {
            point.state.time_s = point.state.time_s.map(|time_s| time_s - begun_s);
        }
        let (run, again) = (fitted(run), fitted(again));
        for (one, other) in run.parameters.iter().zip(&again.parameters) {
            if let (Some(u), Some(again)) = (one.u, other.u) {
                ln_ratios.push((again / u).ln());
            }
        }
    }
    let rms = (ln_ratios.iter().map(|ln| ln * ln).sum::<f64>() / ln_ratios.len() as f64).sqrt();
    assert!(rms < 0.13, "u differ by {rms}");
}
