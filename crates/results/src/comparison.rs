//! Where a model fails, and what one more effect would do.

use crate::diagnosis::{Diagnosis, Verdict};
use crate::identification::Identification;
use crate::ladder::Moved;
use crate::time_quality::TimeQuality;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_engine::compare;

/// `trunnion-comparison/1`: the residual of a fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Comparison {
    /// Format and version.
    pub format: ComparisonFormat,
    /// How well each run with time stamps is known in time.
    pub time_quality: Vec<TimeQuality>,
    /// Where the model fails most, worst first; empty when no place stands out.
    pub places: Vec<Place>,
    /// The fit.
    pub identification: Identification,
    /// What is missing from the model.
    pub diagnosis: Diagnosis,
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
    /// Parameters of the other effects that moved.
    pub moved: Option<Vec<Moved>>,
    /// The fit with the effect.
    pub identification: Identification,
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

/// A diagnosis in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Then {
    /// The verdict.
    pub verdict: Verdict,
    /// The first candidate.
    pub candidate: Option<String>,
}

/// One place where a model fails.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Place {
    /// The place in words.
    pub words: String,
    /// `X`, `Y`, `Z` in machine axes, `table X`, … in the axes of the turned table, `bar length`.
    pub component: String,
    /// Ranges of the axes that matter; empty when it is everywhere.
    pub ranges: Vec<String>,
    /// Directions of travel; empty when they are not known.
    pub direction: String,
    /// The setups; empty when there is only one.
    pub setup: String,
    /// The time; empty when it does not matter.
    pub time: String,
    /// Mean of measured − predicted, µm; with `turns_with` the mean with that axis going forward.
    pub mean_um: f64,
    /// The axis whose direction of travel turns the sign over.
    pub turns_with: Option<String>,
    /// Scalar readings in it.
    pub readings: usize,
    /// Share of the residual's sum of squares that its mean explains, 0…1.
    pub share: f64,
}

impl From<&Diagnosis> for Then {
    fn from(diagnosis: &Diagnosis) -> Self {
        Self {
            verdict: diagnosis.verdict,
            candidate: diagnosis.candidates.first().map(|candidate| candidate.effect.clone()),
        }
    }
}

impl From<&compare::Place> for Place {
    fn from(place: &compare::Place) -> Self {
        Self {
            words: place.to_string(),
            component: place.component.clone(),
            ranges: place.ranges.clone(),
            direction: place.direction.clone(),
            setup: place.setup.clone(),
            time: place.time.clone(),
            mean_um: place.mean_um,
            turns_with: place.turns_with.clone(),
            readings: place.readings,
            share: place.share,
        }
    }
}
