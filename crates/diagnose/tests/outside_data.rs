//! Acceptance on points that another simulator made (tests/data/PROVENANCE.md).

#![allow(clippy::unwrap_used, reason = "tests")]

mod common;

use common::points_set;
use trunnion_diagnose::{Diagnosis, Options, Verdict, diagnose};
use trunnion_effects::{Model, ModelEffect};
use trunnion_identify::Experiment;

fn diagnosed(set: &str, added: &[&str]) -> Diagnosis {
    let run = points_set(set);
    let mut model = Model::base(&run.machine.name);
    for id in added {
        model.effects.push(ModelEffect { id: (*id).into(), ..ModelEffect::default() });
    }
    let experiment = Experiment::new(&[run]).unwrap();
    let begin = std::time::Instant::now();
    let diagnosis = diagnose(&experiment, &model, &Options::default()).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "{set} + {added:?}: {:?}, {seconds:.2} s, rms {:.3}, noise {:.3}",
        diagnosis.verdict, diagnosis.residual.rms_um, diagnosis.residual.noise_um
    );
    for c in &diagnosis.candidates {
        println!(
            "  {} 10^{:.1}, {:.3} µm, held out {:.3}, explains {:.2}, adequate {}, confused {:?}",
            c.effect,
            c.evidence,
            c.rms_um_after,
            c.holdout_rms_um_after,
            c.explains_fraction,
            c.adequate,
            c.confused_with
        );
    }
    println!("  {:?}", diagnosis.formula);
    diagnosis
}

#[test]
fn where_nothing_is_hidden_nothing_is_claimed() {
    let diagnosis = diagnosed("points-nothing-hidden", &[]);
    assert_eq!(diagnosis.verdict, Verdict::NoiseFloor);
    assert!(diagnosis.candidates.is_empty());
    assert!(diagnosis.formula.is_none());
}

#[test]
fn the_pull_of_hoses_gets_no_confident_wrong_name() {
    let diagnosis = diagnosed("points-unnamed", &[]);
    let confident = diagnosis.verdict == Verdict::MissingEffect && diagnosis.candidates[0].adequate;
    assert!(!confident, "{:?}", diagnosis.candidates[0].effect);
    assert_ne!(diagnosis.verdict, Verdict::NoiseFloor);
}

#[test]
fn gravity_sag_is_found_first() {
    let diagnosis = diagnosed("points-gravity", &[]);
    assert_eq!(diagnosis.verdict, Verdict::MissingEffect);
    assert_eq!(diagnosis.candidates[0].effect, "gravity-sag:B");
    assert!(diagnosis.candidates[0].holdout_rms_um_after < diagnosis.residual.rms_um);
}

#[test]
fn backlash_and_drift_are_found_one_after_the_other() {
    let truth = ["backlash:C", "thermal-drift"];
    let first = diagnosed("points-backlash-and-drift", &[]).candidates[0].effect.clone();
    assert!(truth.contains(&first.as_str()), "{first}");
    let second = diagnosed("points-backlash-and-drift", &[&first]).candidates[0].effect.clone();
    assert!(truth.contains(&second.as_str()) && second != first, "{second}");
}
