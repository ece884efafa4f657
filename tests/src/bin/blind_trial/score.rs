//! Right or wrong, and how much of the truth was caught.

use crate::cases::Group;
use crate::stage::{Grid, Stage, experiment};
use crate::trial::Staged;
use nalgebra::DVector;
use trunnion_effects::{Formula, Instance, Model, ModelEffect};
use trunnion_engine::fit::Options;
use trunnion_engine::{Diagnosis, Experiment, Identification, Verdict, identify};
use trunnion_hil_sim::Truth;
use trunnion_machine::Machine;

/// A named set that removes at least this share of the hidden signal is as good as the truth.
pub const EQUIVALENT: f64 = 0.97;

/// What an answer is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Nothing hidden, and said so.
    Quiet,
    /// Nothing hidden, something claimed.
    Claim,
    /// Exactly the hidden set.
    Exact,
    /// Other names that say the same, on this grid and on the unseen one.
    Equivalent,
    /// These data cannot say.
    Undecided,
    /// All clear, and something was hidden.
    Missed,
    /// Only a part of the hidden set.
    Fewer,
    /// The hidden set and more.
    Extra,
    /// Said to be in no catalogue.
    Unnamed,
    /// Another name, confirmed.
    Wrong,
    /// Another name, with the remark that a part remains.
    Doubted,
}

impl Outcome {
    pub fn name(self) -> &'static str {
        match self {
            Self::Quiet => "quiet",
            Self::Claim => "claim",
            Self::Exact => "exact",
            Self::Equivalent => "equivalent",
            Self::Undecided => "undecided",
            Self::Missed => "missed",
            Self::Fewer => "fewer",
            Self::Extra => "extra",
            Self::Unnamed => "unnamed",
            Self::Wrong => "wrong",
            Self::Doubted => "doubted",
        }
    }

    /// Whether a person would have been helped.
    pub fn is_good(self, group: Group) -> bool {
        match group {
            Group::Null => self == Self::Quiet,
            Group::Single | Group::Pair => matches!(self, Self::Exact | Self::Equivalent),
            Group::TakenOut | Group::Unnamed => matches!(self, Self::Unnamed | Self::Equivalent),
        }
    }
}

/// Judges an answer by the truth.
pub fn outcome(
    stage: &Stage,
    staged: &Staged,
    group: Group,
    wanted: &[String],
    diagnosis: &Diagnosis,
) -> Outcome {
    let found: Vec<&String> = diagnosis.set.iter().map(|entry| &entry.id).collect();
    let silent = matches!(diagnosis.verdict, Verdict::NoiseFloor | Verdict::Undecided);
    let claims = !silent || !found.is_empty();
    match (group, claims) {
        (_, false) if diagnosis.verdict == Verdict::Undecided => return Outcome::Undecided,
        (Group::Null, false) => return Outcome::Quiet,
        (Group::Null, true) => return Outcome::Claim,
        (_, false) => return Outcome::Missed,
        (_, true) => {}
    }
    if diagnosis.verdict == Verdict::UnnamedStructure {
        return Outcome::Unnamed;
    }
    let all_found = wanted.iter().all(|id| found.contains(&id));
    let all_wanted = found.iter().all(|id| wanted.contains(id));
    if matches!(group, Group::Single | Group::Pair) {
        match (all_found, all_wanted) {
            (true, true) => return Outcome::Exact,
            (true, false) => return Outcome::Extra,
            (false, true) => return Outcome::Fewer,
            (false, false) => {}
        }
    }
    let only_named = found.iter().all(|id| Formula::name_of(id).is_none());
    if only_named && found.len() <= wanted.len() && says_the_same(stage, staged, &diagnosis.set) {
        return Outcome::Equivalent;
    }
    let adequate = diagnosis.candidates.first().is_some_and(|best| best.adequate());
    if only_named && adequate { Outcome::Wrong } else { Outcome::Doubted }
}

/// Base model and a set; formulas of the same name get numbers.
pub fn with_set(machine: &Machine, set: &[ModelEffect]) -> Model {
    let mut model = Model::base(&machine.name);
    for entry in set {
        let mut entry = entry.clone();
        let taken = |id: &str| model.effects.iter().any(|other| other.id == id);
        if taken(&entry.id) {
            let number = (2..).find(|n| !taken(&format!("{}-{n}", entry.id))).expect("numbers do not end");
            entry.id = format!("{}-{number}", entry.id);
        }
        model.effects.push(entry);
    }
    model
}

/// Whether a set, fitted to what is hidden without noise, removes it on both grids: with the shape numbers found, or with the best.
fn says_the_same(stage: &Stage, staged: &Staged, set: &[ModelEffect]) -> bool {
    let free: Vec<ModelEffect> =
        set.iter().map(|entry| ModelEffect { shape: Vec::new(), ..entry.clone() }).collect();
    let exact = experiment(&stage.trial.run("noise-free", &stage.trial.ideal_mm(&staged.truth)));
    let unseen = unseen_experiment(stage, &exact, &staged.truth);
    let unseen_mm = stage.unseen.hidden_mm(&staged.truth);
    [set, &free].into_iter().any(|set| {
        let model = with_set(&stage.machine, set);
        let Ok(fit) = identify(&exact, &model, &Options::quick()) else { return false };
        let here = captured(&stage.trial, &staged.hidden_mm, &predicted_mm(&exact, &model, &fit));
        let there = captured(&stage.unseen, &unseen_mm, &predicted_mm(&unseen, &model, &fit));
        here >= EQUIVALENT && there >= EQUIVALENT
    })
}

/// Share of the surviving hidden variance on the unseen cycle that the effects of a fit remove.
pub fn captured_unseen(stage: &Stage, staged: &Staged, model: &Model, fit: &Identification) -> f64 {
    let unseen = unseen_experiment(stage, &staged.experiment, &staged.truth);
    captured(&stage.unseen, &stage.unseen.hidden_mm(&staged.truth), &predicted_mm(&unseen, model, fit))
}

/// The same share on the poses of the trial.
pub fn captured_here(stage: &Stage, staged: &Staged, model: &Model, fit: &Identification) -> f64 {
    captured(&stage.trial, &staged.hidden_mm, &predicted_mm(&staged.experiment, model, fit))
}

/// The unseen cycle in the scene of the trial: ranges and times that scale an effect are those it was fitted with.
fn unseen_experiment(stage: &Stage, trial: &Experiment, truth: &Truth) -> Experiment {
    let mut unseen = experiment(&stage.unseen.run("unseen", &stage.unseen.ideal_mm(truth)));
    let setups = std::mem::take(&mut unseen.scene.setups);
    unseen.scene = trunnion_effects::Scene { setups, ..trial.scene.clone() };
    unseen
}

/// What the effects beside the base model say, mm.
fn predicted_mm(experiment: &Experiment, model: &Model, fit: &Identification) -> DVector<f64> {
    let mut predicted = DVector::zeros(experiment.rows());
    for (entry, fitted) in model.effects.iter().zip(&fit.effects) {
        if trunnion_effects::catalogue::BASE.contains(&entry.id.as_str()) {
            continue;
        }
        let instance = Instance::from_model_effect(entry, experiment.machine())
            .expect("what was fitted can be placed again");
        let columns = experiment.columns(&instance, &fitted.shape);
        let first = fit.parameters.iter().position(|parameter| parameter.effect == entry.id);
        let Some(first) = first else { continue };
        predicted += &columns * fit.solution.rows(first, columns.ncols());
    }
    predicted
}

/// 1 − |what survives of hidden − predicted|² / |what survives of hidden|².
fn captured(grid: &Grid, hidden: &DVector<f64>, predicted: &DVector<f64>) -> f64 {
    1.0 - grid.surviving(&(hidden - predicted)).norm_squared() / grid.surviving(hidden).norm_squared()
}
