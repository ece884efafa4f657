//! Acceptance on points that another simulator made (tests/data/PROVENANCE.md).

use crate::common::{points_run, set};
use std::f64::consts::LN_10;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::diagnosis::Options;
use trunnion_engine::fit::doubts::DoubtReason;
use trunnion_engine::{Candidate, Diagnosis, Doubt, Experiment, Verdict, diagnose};

fn diagnosed(set: &str, added: &[&str]) -> Diagnosis {
    let run = points_run(set);
    let mut model = Model::base(&run.machine.name);
    for id in added {
        model.effects.push(ModelEffect { id: (*id).into(), ..ModelEffect::default() });
    }
    let experiment = Experiment::new(&[run]).unwrap();
    diagnose(&experiment, &model, &Options::default()).unwrap()
}

#[test]
fn where_nothing_is_hidden_nothing_is_claimed() {
    let diagnosis = diagnosed("points-nothing-hidden", &[]);
    assert_eq!(diagnosis.verdict, Verdict::NoiseFloor);
    assert!(diagnosis.candidates.is_empty());
    assert!(diagnosis.formula.is_none());
}

#[test]
fn the_pull_of_hoses_is_said_to_be_in_no_catalogue_and_gets_an_expression() {
    let diagnosis = diagnosed("points-unnamed", &[]);
    assert_eq!(diagnosis.verdict, Verdict::UnnamedStructure);
    assert!(diagnosis.candidates.iter().all(|candidate| !candidate.adequate()));
    let formula = diagnosis.formula.unwrap();
    assert_eq!(formula.site, "axis:B");
    assert!(formula.explains_fraction > 0.9, "{}", formula.explains_fraction);
    // The named effect closest to it is the one that leaves least.
    let left_um: Vec<f64> = diagnosis.candidates.iter().map(|candidate| candidate.rms_um_after).collect();
    assert!(left_um.is_sorted() && left_um.len() > 1, "{left_um:?}");
    assert_eq!(formula.resembles.as_ref(), Some(&diagnosis.candidates[0].effect));
}

#[test]
fn what_is_a_candidate_or_in_what_was_found_is_not_said_to_be_invisible() {
    for points in ["points-unnamed", "points-gravity", "points-backlash-and-drift"] {
        let diagnosis = diagnosed(points, &[]);
        let named = diagnosis.candidates.iter().map(|candidate| &candidate.effect);
        let confused = diagnosis.candidates.iter().flat_map(|candidate| &candidate.confused_with);
        for id in named.chain(confused) {
            assert!(!diagnosis.not_visible.contains(id), "{points}: {id}");
        }
    }
}

#[test]
fn gravity_sag_is_found_first() {
    let diagnosis = diagnosed("points-gravity", &[]);
    assert_eq!(diagnosis.verdict, Verdict::MissingEffect);
    assert_eq!(diagnosis.candidates[0].effect, "gravity-sag:B");
    assert!(diagnosis.candidates[0].holdout_rms_um_after.unwrap() < diagnosis.residual.rms_um);
    assert_eq!(set(&diagnosis), ["gravity-sag:B"]);
    assert!(diagnosis.candidates[0].adequate());
}

/// A reading of a metre, or the overflow mark of an instrument, is left out of the fit. It decided the diagnosis all the same: another
/// cause, or none.
#[test]
fn one_wild_reading_decides_nothing() {
    let good = diagnosed("points-gravity", &[]);
    for wild_mm in [1e3, 9.99e34] {
        let mut run = points_run("points-gravity");
        run.points[100].reading_mm[1] = wild_mm;
        let model = Model::base(&run.machine.name);
        let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
        assert_eq!(set(&found), set(&good), "{wild_mm}");
        let [with, without] = [&found, &good].map(|found| &found.candidates[0]);
        // One point of 336 less.
        assert!(
            (with.evidence / without.evidence - 1.0).abs() < 0.03,
            "{} {}",
            with.evidence,
            without.evidence
        );
        assert_eq!(with.adequate(), without.adequate());
    }
}

/// All gains together make all errors larger, so that none of them has a number: their differences have.
#[test]
fn gains_of_probes_are_named_by_their_differences() {
    let mut run = points_run("points-nothing-hidden");
    for point in &mut run.points {
        point.reading_mm[0] *= 0.7;
        point.reading_mm[1] *= 0.7;
    }
    let model = Model::base(&run.machine.name);
    let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
    let gain = &found.candidates[0];
    assert_eq!(gain.effect, "probe-gain");
    assert!(gain.parameters.iter().all(|p| p.value.is_none()));
    // 1/0.7 − 1 = 0.43, as a part of readings that the model predicts too small.
    let differences: Vec<f64> = gain.seen_together.iter().map(|seen| seen.value.abs()).collect();
    assert!(differences.iter().any(|size| (300.0..450.0).contains(size)), "{:?}", gain.seen_together);
}

/// Cables or amplifiers that couple: without an effect of its own, a turn of the nest with a tilt and an unbalance.
#[test]
fn a_share_of_one_probe_in_another_is_named_with_its_size() {
    for (into, of, share) in [(0, 1, 0.2), (2, 0, 0.1), (1, 2, 0.3)] {
        let mut run = points_run("points-nothing-hidden");
        run.points.iter_mut().for_each(|point| point.reading_mm[into] += share * point.reading_mm[of]);
        let model = Model::base(&run.machine.name);
        let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
        assert_eq!(set(&found), ["probe-crosstalk"]);
        for parameter in &found.candidates[0].parameters {
            let name = format!("{}-of-{}", ["x", "y", "z"][into], ["x", "y", "z"][of]);
            let truth = if parameter.name == name { 1000.0 * share } else { 0.0 };
            let (value, u) = (parameter.value.unwrap(), parameter.u.unwrap());
            assert!((value - truth).abs() < 4.0 * u && u < 10.0, "{name}: {} {value} ± {u}", parameter.name);
        }
    }
}

#[test]
fn what_is_there_too_is_no_rival_and_numbers_are_doubted_before_they_are_added() {
    let second = diagnosed("points-backlash-and-drift", &["thermal-drift"]);
    let backlash = &second.candidates[0];
    assert_eq!((backlash.effect.as_str(), backlash.confused_with.len()), ("backlash:C", 0));
    let both = diagnosed("points-backlash-and-drift", &[]);
    let drift = both.candidates.iter().find(|one| one.effect == "thermal-drift").unwrap();
    let is_long = |doubt: &Doubt| matches!(doubt.reason, DoubtReason::LongerThanRun { .. });
    assert!(drift.doubts.iter().any(is_long), "{:?}", drift.doubts);
}

#[test]
fn backlash_and_drift_are_found_one_after_the_other() {
    let truth = ["backlash:C", "thermal-drift"];
    let both = diagnosed("points-backlash-and-drift", &[]);
    assert_eq!(set(&both), truth);
    // Each alone leaves the other; together they leave what repeats show.
    let together = both.together.as_ref().unwrap();
    let repeatability_um = both.residual.noise_um.unwrap();
    assert!(together.rms_um < 1.2 * repeatability_um, "{together:?} {repeatability_um}");
    // Next to the other each is worth its name.
    let stands = |one: &Candidate| one.evidence * LN_10 > Options::default().claim_ln;
    assert!(both.candidates.iter().filter(|one| truth.contains(&one.effect.as_str())).all(stands));
    assert!(both.candidates.iter().all(|one| one.rms_um_after > 2.0 * together.rms_um && !one.adequate()));
    for id in truth {
        assert!(together.parameters.iter().any(|p| p.effect == id && p.u.is_some()), "{together:?}");
    }
    // What is not adequate says why, and what to do.
    assert_eq!(both.why.contains("Add it to the model, then diagnose again"), !together.adequate);
    let first = both.candidates[0].effect.clone();
    assert!(truth.contains(&first.as_str()), "{first}");
    let second = diagnosed("points-backlash-and-drift", &[&first]).candidates[0].effect.clone();
    assert!(truth.contains(&second.as_str()) && second != first, "{second}");
}

/// Odds may not hang on digits that no probe has. With a noise that stopped half way those of the backlash were 10^8.8 or 10^15.7.
#[test]
fn the_last_digits_of_the_readings_do_not_change_the_odds() {
    let evidence = |last_mm: f64| {
        let mut run = points_run("points-backlash-and-drift");
        let readings = run.points.iter_mut().flat_map(|point| &mut point.reading_mm);
        readings.enumerate().for_each(|(i, reading)| *reading += last_mm * ((i * 7919 % 13) as f64 - 6.0));
        let model = Model::base(&run.machine.name);
        let found = diagnose(&Experiment::new(&[run]).unwrap(), &model, &Options::default()).unwrap();
        found.candidates.into_iter().map(|one| (one.effect, one.evidence)).collect::<Vec<_>>()
    };
    let as_given = evidence(0.0);
    for last_mm in [1e-9, -2e-9] {
        let changed = evidence(last_mm);
        assert_eq!(changed.len(), as_given.len(), "{as_given:?} {changed:?}");
        // The noise is learned to a quarter in ln, with and without each effect.
        let is_same =
            |a: &(String, f64), b: &(String, f64)| a.0 == b.0 && (a.1 - b.1).abs() < 2.0 * 0.25 / LN_10;
        assert!(as_given.iter().zip(&changed).all(|(a, b)| is_same(a, b)), "{as_given:?} {changed:?}");
    }
}
