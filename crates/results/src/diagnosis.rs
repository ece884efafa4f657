//! A diagnosis: which effect is missing from the model, as far as the data can say.

use crate::complete::Complete;
use crate::identification::{LeftOut, Parameter};
use crate::spectrum::Period;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects::Formula;

pub use trunnion_engine::next_cycle::PlannedCycle;
pub use trunnion_engine::{LearnedNoise, OpenEffect, Verdict};

/// `trunnion-diagnosis/1`: the answer of a diagnosis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Diagnosis {
    /// Format and version.
    pub format: DiagnosisFormat,
    /// Ids of the effects of the model that was judged, in order.
    pub model: Vec<String>,
    /// Size of what this model leaves.
    pub residual: Residual,
    /// The answer in one word.
    pub verdict: Verdict,
    /// Why these data cannot say, of an `undecided`; why nothing was judged; why a structure has no expression; what was found but cannot be
    /// fitted; what all that was found together leaves, and what to do. Else empty.
    #[serde(default)]
    pub why: String,
    /// What the noise learned from these readings consists of.
    #[serde(default)]
    pub noise: LearnedNoise,
    /// Size of a usual effect that would almost always have been noticed, µm rms of what the model leaves of it; null where no
    /// effect is visible.
    #[serde(default)]
    pub noticeable_um: Option<f64>,
    /// Effects that have something to say for them, but not enough to be named.
    #[serde(default)]
    pub undecided: Vec<OpenEffect>,
    /// Candidates, best first; empty when nothing is claimed.
    pub candidates: Vec<Candidate>,
    /// Ids of the effects that together explain the residual.
    pub set: Vec<String>,
    /// What the whole set does, as adding all of it gives it, shapes fitted again; null where it is not more than one, or that fit failed.
    #[serde(default)]
    pub together: Option<Together>,
    /// An expression that describes the residual better than any effect of the catalogue.
    pub formula: Option<FormulaProposal>,
    /// What to measure next.
    pub next_cycle: Option<NextCycle>,
    /// Effects that this cycle cannot show: the model imitates them.
    #[serde(default)]
    pub not_visible: Vec<String>,
    /// Effects that these runs cannot have (no time stamps, nothing moved, one load, …).
    #[serde(default)]
    pub out_of_reach: Vec<String>,
    /// What is planned, read, missing and excluded.
    #[serde(default)]
    pub complete: Complete,
}

/// Format and version of a diagnosis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DiagnosisFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-diagnosis/1")]
    V1,
}

/// Size of the residual of a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Residual {
    /// Root mean square without outliers, µm per component.
    pub rms_um: f64,
    /// Held-out error, µm rms; null when nothing could be left out.
    pub holdout_rms_um: Option<f64>,
    /// The unit that was left out in turn.
    pub holdout_unit: Option<LeftOut>,
    /// Repeatability of a reading, µm per component; null where no pose was measured twice.
    pub noise_um: Option<f64>,
    /// Readings averaged in one of which `noise_um` is the scatter, the mean: 1 for single readings; null where it is.
    #[serde(default)]
    pub noise_readings: Option<f64>,
    /// Share of the residual's mean square that all that was found together leaves, 0…1; 1 where nothing was found, null where nothing was
    /// judged.
    pub unexplained_fraction: Option<f64>,
}

/// One effect that would explain part of the residual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Candidate {
    /// Effect id.
    pub effect: String,
    /// log₁₀ of the odds against noise only: Bayes factor times prior, after the price of the choice among all candidates.
    pub evidence: f64,
    /// Residual with it in the model, µm rms.
    pub rms_um_after: f64,
    /// Held-out error with it in the model, µm rms; null when nothing could be left out.
    pub holdout_rms_um_after: Option<f64>,
    /// What it explains alone, as a share of what everything that was found explains together, 0…1.
    pub explains_fraction: f64,
    /// Its parameters as fitted with it alone, shape numbers included; of what was found together, `together` has those of the common
    /// fit.
    pub parameters: Vec<Parameter>,
    /// Effects that the data do not well distinguish from it.
    pub confused_with: Vec<String>,
    /// The measurement that would separate them; empty when it is confused with none.
    pub separate_by: String,
    /// True when nothing structured remains with it alone, and no error along an axis would read the same.
    pub adequate: bool,
    /// True when nothing structured remains with it alone.
    #[serde(default)]
    pub explains_all: bool,
    /// The period, where the effect waves along an axis.
    #[serde(default)]
    pub period: Option<Period>,
    /// What a person should know of it that no number here says.
    #[serde(default)]
    pub remarks: Vec<String>,
    /// What it is and what speaks for it.
    pub why: String,
}

/// What all effects of a set do in one model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Together {
    /// Residual with all of them in the model, µm rms.
    pub rms_um_after: f64,
    /// Held-out error with all of them in the model, µm rms; null when nothing could be left out.
    pub holdout_rms_um_after: Option<f64>,
    /// Share of what can be explained that they explain, 0…1.
    pub explains_fraction: f64,
    /// Their parameters as fitted together, shape numbers included.
    pub parameters: Vec<Parameter>,
    /// True when nothing structured remains with all of them, and no error along an axis would read the same as one of them.
    pub adequate: bool,
    /// True when nothing structured remains with all of them.
    #[serde(default)]
    pub explains_all: bool,
}

impl Together {
    /// The parameters of one of them.
    pub fn parameters_of(&self, effect: &str) -> Vec<&Parameter> {
        self.parameters.iter().filter(|p| p.effect == effect).collect()
    }
}

/// An expression ready to add as `formula:NAME`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FormulaProposal {
    /// Name of the effect.
    pub name: String,
    /// Where it acts: `axis:B`, `ball`, `spindle`, …
    pub site: String,
    /// `dx` … `ec`.
    pub component: String,
    /// The expression.
    pub expression: String,
    /// Values of its shape numbers.
    pub shape: Vec<ShapeNumber>,
    /// Ids of the further entries of the proposal, one for each further component.
    pub also: Vec<String>,
    /// The components of all entries, the first one's first.
    #[serde(default)]
    pub components: Vec<String>,
    /// log₁₀ of the odds against noise only: Bayes factor times prior, after the price of the choice among all candidates.
    pub evidence: f64,
    /// Residual with it in the model, µm rms.
    pub rms_um_after: f64,
    /// Held-out error with it in the model, µm rms; null when nothing could be left out.
    pub holdout_rms_um_after: Option<f64>,
    /// What it explains alone, as a share of what everything that was found explains together, 0…1.
    pub explains_fraction: f64,
    /// What it does, and where, in words.
    #[serde(alias = "lives")]
    pub location: String,
    /// The effect of the catalogue it resembles most.
    pub resembles: Option<String>,
}

/// A shape number of an expression.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShapeNumber {
    /// Its name in the expression.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// `rad`, `s`, `rad/s`, `rad/mm` or `1`.
    pub unit: String,
}

/// What to measure next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextCycle {
    /// What to do.
    pub suggestion: String,
    /// The planned cycle; null when none was planned or none helps.
    pub cycle: Option<PlannedCycle>,
}

impl Diagnosis {
    /// Share of the residual's mean square that what was found explains, where anything was found.
    pub fn explained(&self) -> Option<f64> {
        let found = !self.candidates.is_empty() || self.formula.is_some();
        self.residual.unexplained_fraction.filter(|_| found).map(|left| 1.0 - left)
    }

    /// What was found does to the readings, µm rms per component: the root of the mean square that it explains.
    pub fn missing_um(&self) -> Option<f64> {
        self.explained().map(|share| share.max(0.0).sqrt() * self.residual.rms_um)
    }

    /// The same where it is smaller than the repeatability: no correction can hold the machine better than it repeats.
    pub fn missing_below_repeatability_um(&self) -> Option<f64> {
        let repeats = self.residual.noise_um?;
        self.missing_um().filter(|&missing| missing < repeats)
    }

    /// Whether the model explains the readings; `None` where this diagnosis does not say.
    pub fn model_adequate(&self) -> Option<bool> {
        match self.verdict {
            Verdict::NoiseFloor => Some(true),
            Verdict::MissingEffect | Verdict::UnnamedStructure => Some(false),
            Verdict::Undecided | Verdict::NotJudged => None,
        }
    }

    /// The named effects that were found together, best first, and what they do; `None` where one leads alone or an expression is
    /// part of it.
    pub fn found_together(&self) -> Option<(Vec<&Candidate>, &Together)> {
        let together = self.together.as_ref().filter(|_| self.verdict == Verdict::MissingEffect)?;
        let found: Vec<_> = self.candidates.iter().filter(|one| self.set.contains(&one.effect)).collect();
        (found.len() == self.set.len()).then_some((found, together))
    }

    /// All that the verdict names: the effects found together, else the effect or formula that leads; empty where it names none.
    pub fn named(&self) -> Vec<String> {
        match self.found_together() {
            Some((found, _)) => found.into_iter().map(|one| one.effect.clone()).collect(),
            None => self.best().into_iter().collect(),
        }
    }

    /// The same for a list of runs: ids, a semicolon between them.
    pub fn named_in_short(named: &[String]) -> Option<String> {
        Some(named.join("; ")).filter(|named| !named.is_empty())
    }

    /// The effect or formula that leads, if the verdict names one.
    pub fn best(&self) -> Option<String> {
        match self.verdict {
            Verdict::MissingEffect => self.candidates.first().map(|candidate| candidate.effect.clone()),
            Verdict::UnnamedStructure => self.formula.as_ref().map(|formula| Formula::id_of(&formula.name)),
            Verdict::NoiseFloor | Verdict::Undecided | Verdict::NotJudged => None,
        }
    }
}
