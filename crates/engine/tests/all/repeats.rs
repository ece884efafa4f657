//! The repeatability is that of visits from one side, where there are such, and says of what it is.

use crate::common::points_run;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_core::{Joint, State};
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::fit::Options;
use trunnion_engine::plausibility::implausible;
use trunnion_engine::{Approach, Experiment, Repeatability, Verdict, diagnose, diagnosis, identify};

const WHITE_MM: f64 = 0.3e-3;

/// White noise alone; the course of the run so often, one after the other. `backlash_mm`: of Y, half of it to either side.
fn rounds(count: usize, backlash_mm: f64) -> Run {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut run = points_run("points-nothing-hidden");
    let once = run.points.clone();
    for round in 0..count {
        for point in &once {
            let mut point = point.clone();
            point.state.time_s = point.state.time_s.map(|time_s| time_s + 2000.0 * round as f64);
            let y_mm = 0.5 * backlash_mm * point.state.direction[Joint::Y];
            // Into table axes: B does not turn Y.
            let (sin_c, cos_c) = point.state.position[Joint::C].sin_cos();
            let table = [sin_c * y_mm, cos_c * y_mm, 0.0];
            point.reading_mm = table.map(|mm| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                mm + WHITE_MM * noise
            });
            run.points.push(point);
        }
    }
    run.points.drain(..once.len());
    run
}

fn repeatability(run: Run) -> Repeatability {
    let model = Model::base(&run.machine.name);
    let experiment = Experiment::new(&[run]).unwrap();
    identify(&experiment, &model, &Options::default()).unwrap().repeatability.expect("repeats")
}

#[test]
fn backlash_between_visits_from_both_sides_is_no_scatter_where_others_come_from_one() {
    let with = repeatability(rounds(2, 3e-3));
    assert_eq!(with.approach, Approach::OneSide);
    assert!((with.sigma_mm / WHITE_MM - 1.0).abs() < 0.1, "{with:?}");
    let without = repeatability(rounds(2, 0.0));
    assert_eq!(without.approach, Approach::NoMatter);
    assert!((without.sigma_mm / WHITE_MM - 1.0).abs() < 0.1, "{without:?}");
}

#[test]
fn visits_that_all_come_from_both_sides_are_said_to() {
    assert_eq!(repeatability(rounds(1, 0.0)).approach, Approach::BothSides);
}

/// More points than a fit takes at rest become means of neighbours.
#[test]
fn a_repeatability_of_means_says_of_how_many_readings() {
    assert_eq!(repeatability(rounds(2, 0.0)).readings, 1.0);
    let run = rounds(32, 0.0);
    let points = run.points.len() as f64;
    let experiment = Experiment::new(&[run]).unwrap();
    let expected = points / experiment.points.len() as f64;
    let fit = identify(&experiment, &Model::base("table-bc"), &Options::default()).unwrap();
    let of_means = fit.repeatability.expect("repeats");
    assert!(expected > 1.2 && (of_means.readings - expected).abs() < 1e-9, "{of_means:?}, {expected}");
    assert!(of_means.sigma_mm < 0.97 * WHITE_MM, "{of_means:?}");
}

/// One probe reads how Y comes back from the other side, up to ± 8 µm: from one side it repeats as the others do, so it is not loose.
#[test]
fn a_probe_that_repeats_from_one_side_is_not_called_loose() {
    let is_loose = |shift: fn(usize, &State) -> f64| {
        let mut run = rounds(2, 0.0);
        for (i, point) in run.points.iter_mut().enumerate() {
            point.reading_mm[2] += 8e-3 * shift(i, &point.state);
        }
        implausible(&[run]).iter().any(|found| found.finding.contains("those of the other probes"))
    };
    assert!(!is_loose(|_, state| state.direction[Joint::Y] * state.position[Joint::C].cos()));
    assert!(is_loose(|i, _| (1.7 * (i * i) as f64).sin()));
}

/// Two rounds of readings, rounded to a step.
fn shown(step_mm: f64) -> Run {
    let mut run = rounds(2, 0.0);
    let shown = |mm: f64| (mm / step_mm).round() * step_mm;
    run.points.iter_mut().for_each(|point| point.reading_mm = point.reading_mm.map(shown));
    run
}

/// The second round is a copy of the first, or both hold their mean: repeats that agree in every digit prove nothing.
#[test]
fn a_pass_whose_readings_are_those_of_another_is_named_and_a_coarse_display_is_not() {
    let is_copy =
        |run: Run| implausible(&[run]).iter().any(|one| one.hypothesis.contains("copied into another"));
    let one_pass_of = |mut run: Run| {
        let (half, count) = (run.points.len() / 2, run.points.len() / 4);
        for k in 0..count {
            run.points[half + k].reading_mm = run.points[k].reading_mm;
        }
        run
    };
    let all_of = |mut run: Run| {
        let half = run.points.len() / 2;
        for k in 0..half {
            run.points[half + k].reading_mm = run.points[k].reading_mm;
        }
        run
    };
    // A calibration turns what a coarse display shows into axes of the nest, and gives it more digits.
    let calibrated = |step_mm: f64| {
        let mut run = shown(step_mm);
        let (sin, cos) = 0.14_f64.sin_cos();
        for point in &mut run.points {
            let [x, y, z] = point.reading_mm;
            let turned = [cos * x - sin * y, sin * x + cos * y, z];
            point.reading_mm = turned.map(|mm| (mm / 1e-5).round() * 1e-5);
        }
        run
    };
    assert!(is_copy(one_pass_of(shown(1e-5))), "a half of the second round");
    assert!(is_copy(all_of(shown(1e-5))), "all of it");
    for good in [shown(1e-5), shown(1e-4), shown(5e-4), shown(1e-3), calibrated(5e-4), calibrated(1e-3)] {
        assert!(!is_copy(good));
    }
    // Behind a display that may hide the noise nothing is known.
    assert!(!is_copy(one_pass_of(shown(5e-4))));
}

/// C moves along Z in two waves a turn, smaller than the noise: one pass does not say whether what is left next to them is noise.
#[test]
fn a_small_cause_is_adequate_only_where_repeats_say_what_noise_is() {
    for count in [1, 2] {
        let mut run = rounds(count, 0.0);
        run.points.retain(|point| point.state.direction[Joint::C] > 0.0);
        for point in &mut run.points {
            point.reading_mm[2] += 0.35e-3 * (2.0 * point.state.position[Joint::C]).cos();
        }
        let experiment = Experiment::new(&[run]).unwrap();
        let found = diagnose(&experiment, &Model::base("table-bc"), &diagnosis::Options::default()).unwrap();
        assert_eq!(found.verdict, Verdict::MissingEffect, "{}", found.why);
        let [cause] = &found.candidates[..] else { panic!("{:?}", found.candidates) };
        assert_eq!(cause.effect, "axial-error-motion:C");
        assert!(cause.rms_um_after.powi(2) > 0.7 * found.residual.rms_um.powi(2));
        assert_eq!(cause.adequate(), count > 1, "{}", found.why);
        let is_asked = found.why.contains("no pose was measured twice") && found.next_cycle.is_some();
        assert_eq!(is_asked, count == 1, "{}", found.why);
    }
}
