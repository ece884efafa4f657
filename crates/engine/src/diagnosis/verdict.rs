//! The answer of a diagnosis.

use crate::diagnosis::judged::{LearnedNoise, OpenEffect, Verdict};
use crate::fit::doubts::Doubt;
use crate::next_cycle::PlannedCycle;
use crate::problem::Problem;
use crate::problem::experiment::Experiment;
use crate::problem::folds::LeftOut;
use crate::problem::last_run::{last_run, rests};
use crate::solve::combinations::Combination;
use crate::spectrum::Wave;
use serde::{Deserialize, Serialize};
use trunnion_core::Joint;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::plain;
use trunnion_cycles::RunKind;
use trunnion_effects::{FixedText, ModelEffect, fixed_text};

/// Two hours and more are said in hours.
const HOURS_FROM_S: f64 = 7200.0;

/// What is missing from a model, as far as the data can say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// Effects of the model that was judged, in order.
    pub model: Vec<String>,
    /// What this model leaves.
    pub residual: ResidualSummary,
    /// The answer in one word.
    pub verdict: Verdict,
    /// Why nothing is claimed and nothing cleared, what was found but cannot be fitted, and what all that was found leaves; else empty.
    pub why: String,
    /// What the learned noise consists of, with all that was found in the model.
    pub noise: LearnedNoise,
    /// Size of a usual effect that would almost always have been noticed, µm rms; `None` where no effect is visible.
    pub noticeable_um: Option<f64>,
    /// Effects that have something to say for them, but not enough.
    pub undecided: Vec<OpenEffect>,
    /// Candidates, best first. Empty when nothing is claimed.
    pub candidates: Vec<Candidate>,
    /// Model entries that together explain what is left, named and unnamed, shapes as refined; empty when nothing is claimed.
    pub set: Vec<ModelEffect>,
    /// What they do together; `None` where not more than one was found.
    pub together: Option<Together>,
    /// An expression that describes the structure better than any named effect, ready to add.
    pub formula: Option<FormulaProposal>,
    /// What to measure next to separate rivals.
    pub next_cycle: Option<NextCycle>,
    /// Effects that this cycle cannot show: the model imitates them.
    pub not_visible: Vec<String>,
    /// Effects that the scene cannot have (no time stamps, nothing moved, one load, …).
    pub out_of_reach: Vec<String>,
}

/// Size of the residual of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualSummary {
    /// Root mean square of the residual without outliers, µm per component.
    pub rms_um: f64,
    /// Error on units left out of the fit, µm rms; `None` where nothing can be left out.
    pub holdout_rms_um: Option<f64>,
    /// The unit that was left out in turn, here and of every candidate.
    pub holdout_unit: Option<LeftOut>,
    /// Repeatability of a reading, µm per component; `None` where no pose was measured twice.
    pub noise_um: Option<f64>,
    /// Readings averaged in one of which that is the scatter.
    pub noise_readings: Option<f64>,
    /// Share of the residual's mean square that all that was found together leaves, 0…1; 1 where nothing was found.
    pub unexplained_fraction: f64,
}

impl Diagnosis {
    /// The answer where the runs are not plausible: what the fit leaves, and `why` nothing was weighed.
    pub fn not_judged(problem: &Problem<'_>, why: String) -> Self {
        let fit = problem.fit();
        Self {
            model: fit.effects.iter().map(|effect| effect.id.clone()).collect(),
            residual: ResidualSummary {
                rms_um: um_from_mm(fit.rms_mm),
                holdout_rms_um: fit.holdout_rms_mm().map(um_from_mm),
                holdout_unit: fit.holdout.map(|holdout| holdout.left_out),
                noise_um: fit.repeatability.map(|noise| um_from_mm(noise.sigma_mm)),
                noise_readings: fit.repeatability.map(|noise| noise.readings),
                unexplained_fraction: f64::NAN,
            },
            verdict: Verdict::NotJudged,
            why,
            noise: LearnedNoise::default(),
            noticeable_um: None,
            undecided: Vec::new(),
            candidates: Vec::new(),
            set: Vec::new(),
            together: None,
            formula: None,
            next_cycle: None,
            not_visible: Vec::new(),
            out_of_reach: Vec::new(),
        }
    }
}

impl Diagnosis {
    /// With the reasons why effects that would fit better cannot be the cause. A claim holds only for what is `real`, found next to
    /// them too: another name may describe what they leave behind. There is no all-clear.
    pub(crate) fn doubted(mut self, experiment: &Experiment, doubts: &[String], real: &[String]) -> Self {
        match self.candidates.first_mut().filter(|first| real.contains(&first.effect)) {
            Some(first) if self.verdict == Verdict::MissingEffect => first.remarks.extend_from_slice(doubts),
            _ => {
                let doubts = doubts.join(" ");
                (self.candidates, self.set, self.together, self.formula) = Default::default();
                self.residual.unexplained_fraction = 1.0;
                self.next_cycle = Some(NextCycle::repeat(experiment));
                self.why = format!("{doubts} {}", self.why).trim_end().into();
                self.verdict = Verdict::Undecided;
            }
        }
        self
    }
}

/// The fit with all that was found, where it is more than one thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Together {
    /// Residual after adding all of it, µm rms.
    pub rms_um: f64,
    /// The same on units left out of the fit, µm rms; `None` where nothing can be left out.
    pub holdout_rms_um: Option<f64>,
    /// Share of what can be explained that it explains, 0…1.
    pub explains_fraction: f64,
    /// Parameters of all of it as fitted together; shape numbers included.
    pub parameters: Vec<CandidateParameter>,
    /// True when nothing structured is left after adding all of it.
    pub explains_all: bool,
    /// True when besides no other cause may be behind one of the effects.
    pub adequate: bool,
}

/// One effect that would explain part of the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Effect id.
    pub effect: String,
    /// log₁₀ of the odds against noise only: Bayes factor times the prior for the number of candidates.
    pub evidence: f64,
    /// Residual after adding it, µm rms.
    pub rms_um_after: f64,
    /// The same on units left out of the fit, µm rms; `None` where nothing can be left out.
    pub holdout_rms_um_after: Option<f64>,
    /// Share of what all that was found explains together that it explains alone, 0…1.
    pub explains_fraction: f64,
    /// Its parameters as fitted; shape numbers included.
    pub parameters: Vec<CandidateParameter>,
    /// Effects that the data do not well distinguish from it.
    pub confused_with: Vec<String>,
    /// The measurement that would separate them; empty when nothing is confused.
    pub separate_by: String,
    /// True when nothing structured is left after adding it alone.
    pub explains_all: bool,
    /// The period, where the effect waves along an axis.
    pub period: Option<Wave>,
    /// What a person should know of it that no number here says: its period in words, and what else was looked at.
    pub remarks: Vec<String>,
    /// Its numbers to doubt, as fitted together with all that was found where it is one of that, else alone.
    pub doubts: Vec<Doubt>,
    /// Combinations of its parameters that have a value although none of these has, fitted likewise.
    pub seen_together: Vec<Combination>,
}

impl Candidate {
    /// Whether it alone explains the data: nothing structured is left, and no doubt names another cause that reads the same.
    pub fn adequate(&self) -> bool {
        self.explains_all && !self.doubts.iter().any(Doubt::is_of_another_cause)
    }
}

/// A fitted parameter of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CandidateParameter {
    /// Id of the effect that it belongs to.
    pub effect: String,
    /// Its name.
    pub name: String,
    /// Value in `unit`; `None` when these data cannot see it.
    pub value: Option<f64>,
    /// Standard uncertainty in `unit`; `None` for a shape number that is no period.
    pub u: Option<f64>,
    /// Unit, e.g. `um`.
    pub unit: String,
}

/// An expression for structure that has no name, as a `formula:NAME` effect of a model file (docs/design/contracts.md §4).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormulaProposal {
    /// Name of the effect.
    pub name: String,
    /// `axis:B`, `ball`, `spindle`, …
    pub site: String,
    /// `dx` … `ec`.
    pub component: String,
    /// Expression over the state with named parameters.
    pub expression: String,
    /// Values of the shape numbers in `expression`.
    pub shape: Vec<ShapeNumber>,
    /// The whole proposal as entries of a model file, one for each component; the first is the one described above.
    pub entries: Vec<ModelEffect>,
    /// log₁₀ of the odds against noise only: Bayes factor times the prior of an expression so complex.
    pub evidence: f64,
    /// Residual after adding it, µm rms.
    pub rms_um_after: f64,
    /// The same on units left out of the fit, µm rms; `None` where nothing can be left out.
    pub holdout_rms_um_after: Option<f64>,
    /// Share of what all that was found explains together that it explains alone, 0…1.
    pub explains_fraction: f64,
    /// Where it acts: frame, direction, range, in words.
    pub location: String,
    /// The named effect it resembles most, if any.
    pub resembles: Option<String>,
}

/// What to measure next to separate rivals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NextCycle {
    /// What to do, for a person.
    pub suggestion: String,
    /// The cycle the planner chose ([`crate::next_cycle::advise`]); `None` before planning, and when no cycle helps.
    pub cycle: Option<PlannedCycle>,
}

impl NextCycle {
    /// Advice of the catalogue; nothing was planned yet.
    pub(crate) fn advice(suggestion: String) -> Self {
        Self { suggestion, cycle: None }
    }

    /// Advice for data that decide nothing, as too little was measured twice: the other direction too, where an axis that turned knows one only.
    pub(crate) fn repeat(experiment: &Experiment) -> Self {
        if let Some(watch) = watch_again(experiment) {
            return Self::advice(watch);
        }
        let what = if experiment.kinds.contains(&RunKind::OnTheFly) { "motion" } else { "poses" };
        let went = |joint: Joint, sign: f64| {
            experiment.points.iter().any(|point| point.state.direction[joint] * sign > 0.0)
        };
        let moved = |joints: Vec<Joint>| -> Vec<Joint> {
            joints.into_iter().filter(|joint| experiment.scene.moves(*joint)).collect()
        };
        // Linear axes that follow a rotary one have no direction of their own to choose.
        let turned = moved(experiment.machine().rotary_joints());
        let chosen = if turned.is_empty() { moved(experiment.machine().linear_joints()) } else { turned };
        let both_ways = chosen.iter().all(|joint| went(*joint, 1.0) && went(*joint, -1.0));
        let other_way = if both_ways { "" } else { ", in the opposite direction too" };
        Self::advice(format!("Repeat this pass: the same {what} once more{other_way}."))
    }
}

/// What to do once more where no axis moved in the last run: the same time; `None` where one did.
fn watch_again(experiment: &Experiment) -> Option<String> {
    let alone = Experiment::new(&[last_run(experiment)?]).ok().filter(rests)?;
    let length = match alone.scene.duration_s().filter(|duration_s| *duration_s > 0.0) {
        None => String::new(),
        Some(s) if s < HOURS_FROM_S => format!(" in {} min", plain(s / 60.0)),
        Some(s) => format!(" in {} h", plain(s / 3600.0)),
    };
    let readings = alone.points.len();
    Some(format!("Watch another day of the same length: {readings} readings at this pose{length}."))
}

/// A shape number of an expression.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeNumber {
    /// Its name in the expression.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// `rad`, `s`, `rad/s`, `rad/mm` or `1`.
    #[serde(deserialize_with = "fixed_text")]
    pub unit: FixedText,
}
