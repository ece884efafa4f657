//! Where a model fails, and what one more effect would do.

use crate::correctable::Correctable;
use crate::diagnosis::{Diagnosis, Verdict};
use crate::identification::{Identification, Parameter};
use crate::ladder::{Ladder, Moved};
use crate::prediction::Prediction;
use crate::residuals::Residuals;
use crate::spectrum::AxisSpectrum;
use crate::time_quality::TimeQuality;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects::ModelEffect;
use trunnion_engine as engine;
use trunnion_engine::Experiment;
use trunnion_engine::compare::places;

pub use trunnion_engine::compare::{AxisRange, Place, Region};

/// `trunnion-comparison/1`: the residual of a fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Format and version.
    pub format: ComparisonFormat,
    /// How well each run with time stamps is known in time.
    pub time_quality: Vec<TimeQuality>,
    /// Where the model fails most, worst first; empty when no place stands out.
    pub places: Vec<Place>,
    /// What the model leaves along each axis that moved by itself, by period.
    #[serde(default)]
    pub spectra: Vec<AxisSpectrum>,
    /// The fit.
    pub identification: Identification,
    /// What is missing from the model, when that was asked.
    pub diagnosis: Option<Diagnosis>,
    /// The effects of the model, with what adding each did.
    pub ladder: Ladder,
    /// The fits of these runs without and with each effect that was added, in order: what was found then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub added: Vec<Trial>,
    /// The values of the model file against these runs, when the machine was held at them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frozen: Option<Prediction>,
    /// The best candidate put in for a trial.
    pub trial: Option<Trial>,
    /// What a control could be given from this fit; null where that was not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correctable: Option<Correctable>,
    /// What is missing from the recordings, one sentence each.
    pub losses: Vec<String>,
    /// Side notes that failed and were left out, one sentence each with the reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Measured and predicted readings.
    pub residuals: Residuals,
    /// The page that was written.
    pub html: Option<String>,
}

/// Format and version of a comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ComparisonFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-comparison/1")]
    V1,
}

/// `trunnion-trial/1`: the fits without and with one more effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Trial {
    /// Format and version.
    pub format: TrialFormat,
    /// Effect id.
    pub effect: String,
    /// `dz at axis:B: k*sin(2*B)` for a formula; empty otherwise.
    pub expression: String,
    /// Ids of the effects of the model without it.
    pub model: Vec<String>,
    /// Residual of the fit, µm rms.
    pub rms_um: BeforeAfter,
    /// Held-out error, µm rms.
    pub holdout_rms_um: BeforeAfter,
    /// Repeatability of a reading, µm; null where no pose was measured twice.
    pub noise_um: Option<f64>,
    /// What the diagnosis finds with the effect in the model.
    pub then: Option<Then>,
    /// Where the model fails most.
    pub places: PlacesBeforeAfter,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Parameters of the other effects that moved.
    pub moved: Option<Vec<Moved>>,
    /// The fit with the effect.
    pub identification: Identification,
    /// Measured and predicted readings.
    pub residuals: ResidualsBeforeAfter,
    /// What each fit leaves along each axis that moved by itself, by period.
    #[serde(default)]
    pub spectra: SpectraBeforeAfter,
    /// The page that was written.
    pub html: Option<String>,
}

/// Format and version of a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TrialFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-trial/1")]
    V1,
}

/// A figure without and with the effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeforeAfter {
    /// Without it.
    pub before: Option<f64>,
    /// With it.
    pub after: Option<f64>,
}

/// Places without and with the effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlacesBeforeAfter {
    /// Without it.
    pub before: Vec<Place>,
    /// With it.
    pub after: Vec<Place>,
}

/// Readings as predicted without and with the effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ResidualsBeforeAfter {
    /// Without it.
    pub before: Residuals,
    /// With it.
    pub after: Residuals,
}

/// Spectra of the residual without and with the effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SpectraBeforeAfter {
    /// Without it.
    pub before: Vec<AxisSpectrum>,
    /// With it.
    pub after: Vec<AxisSpectrum>,
}

/// A diagnosis in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Then {
    /// The verdict.
    pub verdict: Verdict,
    /// The first candidate.
    pub candidate: Option<String>,
    /// Why, where nothing is claimed.
    #[serde(default)]
    pub why: String,
}

impl Comparison {
    /// The comparison of a fit. Ladder, trial, losses and time quality are the caller's to fill in.
    pub fn new(experiment: &Experiment, fit: &engine::Identification, diagnosis: Option<Diagnosis>) -> Self {
        // Where the diagnosis finds nothing but noise, or does not judge, no place is blamed.
        let silent = diagnosis.as_ref().is_some_and(|d| d.verdict.blames_no_place());
        Self {
            places: if silent { Vec::new() } else { worst_places(experiment, fit) },
            identification: Identification::from(fit)
                .judged(diagnosis.as_ref().and_then(Diagnosis::model_adequate)),
            diagnosis,
            residuals: residuals(experiment, fit),
            ..Self::default()
        }
    }
}

impl Trial {
    /// The fits without and with `entry`, which carries the ladder row of all that was added, `added` entry by entry; `then` is
    /// the diagnosis of the model with it. Spectra are the caller's to fill in.
    pub fn new(
        experiment: &Experiment,
        entry: &ModelEffect,
        added: &[ModelEffect],
        [before, after]: [&engine::Identification; 2],
        then: Option<&Diagnosis>,
    ) -> Self {
        let silent = then.is_some_and(|then| then.verdict.blames_no_place());
        let components: Vec<&str> = added.iter().filter_map(|entry| entry.component.as_deref()).collect();
        let expression = match (&entry.site, &entry.expression) {
            (Some(site), Some(expression)) => format!("{} at {site}: {expression}", components.join(", ")),
            _ => String::new(),
        };
        let [without, with] = [before, after].map(Identification::from);
        let is_new = |p: &&Parameter| added.iter().any(|entry| entry.id == p.effect);
        Self {
            format: TrialFormat::V1,
            effect: entry.id.clone(),
            expression,
            model: without.effects,
            rms_um: BeforeAfter { before: Some(without.rms_um), after: Some(with.rms_um) },
            holdout_rms_um: BeforeAfter { before: without.holdout_rms_um, after: with.holdout_rms_um },
            noise_um: with.noise_um,
            then: then.map(Then::from),
            places: PlacesBeforeAfter {
                before: worst_places(experiment, before),
                after: if silent { Vec::new() } else { worst_places(experiment, after) },
            },
            parameters: with.parameters.iter().filter(is_new).cloned().collect(),
            moved: Some(entry.ladder.as_ref().map_or_else(Vec::new, |row| row.moved.clone())),
            residuals: ResidualsBeforeAfter {
                before: residuals(experiment, before),
                after: residuals(experiment, after),
            },
            spectra: SpectraBeforeAfter::default(),
            identification: with.judged(then.and_then(Diagnosis::model_adequate)),
            html: None,
        }
    }
}

fn worst_places(experiment: &Experiment, fit: &engine::Identification) -> Vec<Place> {
    places(experiment, &fit.residual_mm, &fit.used)
}

fn residuals(experiment: &Experiment, fit: &engine::Identification) -> Residuals {
    Residuals::new(experiment, &fit.predicted_mm, &fit.used)
}

impl From<&Diagnosis> for Then {
    fn from(diagnosis: &Diagnosis) -> Self {
        Self {
            verdict: diagnosis.verdict,
            candidate: diagnosis.candidates.first().map(|candidate| candidate.effect.clone()),
            why: diagnosis.why.clone(),
        }
    }
}
