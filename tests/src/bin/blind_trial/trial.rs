//! One trial: hide, measure, ask, compare with the truth.

use crate::cases::{Case, Group};
use crate::score::Outcome;
use crate::stage::{RUN_S, Stage, experiment, rms, stacked};
use crate::{cases, library, noise, score};
use nalgebra::DVector;
use std::collections::BTreeSet;
use std::time::Instant;
use trunnion_effects::Model;
use trunnion_engine as diagnose;
use trunnion_engine::fit::Options;
use trunnion_engine::{Diagnosis, Experiment, Outliers, Verdict, identify};
use trunnion_hil_sim::Truth;
use trunnion_tests::baselines;

/// A machine with its secret, and what was read on it.
pub struct Staged {
    pub truth: Truth,
    pub readings_mm: Vec<[f64; 3]>,
    /// What the program under test gets.
    pub experiment: Experiment,
    /// What the hidden physics did to these readings, mm.
    pub hidden_mm: DVector<f64>,
}

/// What came of a trial.
pub struct Trial {
    pub case: Case,
    /// Ids of the truth in the words of the catalogue.
    pub wanted: Vec<String>,
    pub verdict: Verdict,
    /// Ids of what was found.
    pub found: Vec<String>,
    /// Expression offered, if any.
    pub expression: Option<String>,
    pub outcome: Outcome,
    /// Share of the surviving hidden variance on the unseen cycle that the found set removes; `None` when nothing was found.
    pub captured: Option<f64>,
    /// The same on the poses of the trial: high beside a low share unseen, these poses cannot tell the two apart.
    pub captured_here: Option<f64>,
    /// rms after base and found set over the rms of the same readings without the hidden part after the base model.
    pub ladder_end: Option<f64>,
    /// What went wrong with fitting the found set.
    pub trouble: Option<String>,
    /// Time of the diagnosis alone, s.
    pub seconds: f64,
    /// What each of the [`BASELINES`] names, in their order; empty where nobody asks them.
    ///
    /// [`BASELINES`]: trunnion_tests::baselines::BASELINES
    pub baselines: Vec<BTreeSet<String>>,
}

/// Draws the machine of a case and measures it.
pub fn stage_case(stage: &Stage, case: &Case) -> Staged {
    let seed = case.own_seed();
    let mut truth = Truth::draw(&stage.machine, &stage.trial.setups, &[], RUN_S, seed)
        .expect("nothing hidden, nothing unknown");
    for (i, id) in case.hidden.iter().enumerate() {
        let hidden = cases::draw(stage, id, case.size, seed.wrapping_add(i as u64));
        truth.hidden.push(hidden.expect("only visible effects are cases"));
    }
    let readings_mm = noise::read_mm(case.noise, &stage.trial, &truth);
    truth.noise = trunnion_hil_sim::truth::Noise::NONE;
    let run = stage.trial.run("trial", &readings_mm);
    Staged { experiment: experiment(&run), hidden_mm: stage.trial.hidden_mm(&truth), readings_mm, truth }
}

/// The id under which the catalogue has a hidden effect; pairs start with the axis that leans.
pub fn catalogue_id(hidden: &str) -> String {
    match hidden.split_once(':') {
        Some((name, pair)) if pair.len() == 2 => {
            let mut letters: Vec<char> = pair.chars().collect();
            letters.sort();
            // The travel of the later axis leans against the earlier one: YX, ZX, ZY.
            format!("{name}:{}{}", letters[1], letters[0])
        }
        _ => hidden.into(),
    }
}

/// Asks the program and judges its answer.
pub fn run(stage: &Stage, case: &Case) -> (Staged, Trial) {
    let staged = stage_case(stage, case);
    let wanted: Vec<String> = case.hidden.iter().map(|id| catalogue_id(id)).collect();
    let base = Model::base(&stage.machine.name);
    let without = if case.group == Group::TakenOut { wanted.clone() } else { Vec::new() };
    let options = diagnose::diagnosis::Options { without, ..diagnose::diagnosis::Options::default() };
    let started = Instant::now();
    let diagnosis = diagnose::diagnose(&staged.experiment, &base, &options)
        .expect("the base model fits the machine and the grid");
    let seconds = started.elapsed().as_secs_f64();
    let mut trial = Trial {
        case: case.clone(),
        verdict: diagnosis.verdict,
        found: diagnosis.set.iter().map(|entry| entry.id.clone()).collect(),
        expression: diagnosis.formula.as_ref().map(|formula| formula.expression.clone()),
        outcome: score::outcome(stage, &staged, case.group, &wanted, &diagnosis),
        captured: None,
        captured_here: None,
        ladder_end: None,
        trouble: None,
        seconds,
        baselines: Vec::new(),
        wanted,
    };
    if matches!(case.group, Group::Null | Group::Single | Group::Pair) {
        let readings = library::readings(stage, &staged).expect("the diagnosis fitted the base model");
        trial.baselines = baselines::named(&library::library(stage, &staged), &readings);
    }
    judge_found(stage, &staged, &diagnosis, &mut trial);
    (staged, trial)
}

/// Fits base and found set to the trial, looks at what remains, and predicts the unseen cycle.
fn judge_found(stage: &Stage, staged: &Staged, diagnosis: &Diagnosis, trial: &mut Trial) {
    if diagnosis.set.is_empty() {
        return;
    }
    // Values only: how uncertain they are is the business of `coverage`.
    let fit_options = Options { outliers: Outliers::Excluded, ..Options::quick() };
    let model = score::with_set(&stage.machine, &diagnosis.set);
    let fit = match identify(&staged.experiment, &model, &fit_options) {
        Ok(fit) => fit,
        Err(error) => {
            trial.trouble = Some(format!("{error}: {:?}", trial.found));
            return;
        }
    };
    if !staged.truth.hidden.is_empty() {
        trial.captured = Some(score::captured_unseen(stage, staged, &model, &fit));
        trial.captured_here = Some(score::captured_here(stage, staged, &model, &fit));
    }
    let innocent = &stacked(&staged.readings_mm) - &staged.hidden_mm;
    let innocent: Vec<[f64; 3]> = innocent.as_slice().chunks_exact(3).map(|r| [r[0], r[1], r[2]]).collect();
    let innocent = experiment(&stage.trial.run("without the hidden part", &innocent));
    let floor = identify(&innocent, &Model::base(&stage.machine.name), &fit_options);
    trial.ladder_end = floor.ok().map(|floor| fit.rms_mm / floor.rms_mm);
}

/// How far the readings are from nothing after the base model, mm; for exports.
pub fn surviving_rms_mm(stage: &Stage, staged: &Staged) -> f64 {
    rms(&stage.trial.surviving(&staged.hidden_mm))
}
