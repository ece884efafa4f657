//! A model against runs that it was not fitted to.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Least share of the readings inside a 95 % band that holds: neighbours err alike, so single runs scatter around 95 %
/// (docs/design/statistics.md §9).
const COVERED: f64 = 0.9;

/// `trunnion-prediction/1`: frozen values of a model against other runs. Only the settings of the new runs are fitted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Prediction {
    /// Format and version.
    pub format: PredictionFormat,
    /// Name of the machine.
    pub machine: String,
    /// Runs that the model was fitted to.
    pub fitted_runs: Vec<String>,
    /// Day of that fit, `YYYY-MM-DD`; may be empty.
    pub fitted_on: String,
    /// Ids of the effects of the model, in order.
    pub effects: Vec<String>,
    /// Scatter of a reading about the model in that fit, µm rms: what a prediction can at best leave.
    pub reading_um: f64,
    /// True when several runs were fitted, so that the band holds what differs between runs.
    pub differences_known: bool,
    /// Each run that was predicted.
    pub runs: Vec<RunPrediction>,
    /// Parameters that the fit did not determine alone.
    pub not_determined: Vec<String>,
    /// What the prediction takes them to be: 0, or what the fit left of what they do together. The band does not hold them.
    #[serde(default)]
    pub taken: Vec<Taken>,
}

/// A parameter without a standard uncertainty, with the value that a prediction takes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Taken {
    /// Id of its effect.
    pub effect: String,
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The value.
    pub value: f64,
}

/// Format and version of a prediction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PredictionFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-prediction/1")]
    V1,
}

/// One run against its prediction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunPrediction {
    /// Name of the run.
    pub run: String,
    /// True when the model was fitted to these very points: then it is no prediction.
    pub was_fitted: bool,
    /// Points of the run.
    pub points: usize,
    /// Scalar readings compared.
    pub readings: usize,
    /// Root mean square of measured − predicted, µm.
    pub rms_um: f64,
    /// The same for a nominal machine, with the settings fitted too.
    pub without_model_rms_um: f64,
    /// Largest |measured − predicted|, µm.
    pub largest_um: f64,
    /// Mean length of measured − predicted over the points, µm, where every point reads x, y and z: what robot makers call mean error.
    pub mean_distance_um: Option<f64>,
    /// Share of the readings inside the 95 % band of the prediction, 0…1.
    pub inside_95_fraction: f64,
    /// Half width of that band, µm (rms over the readings).
    pub band_95_um: f64,
    /// Parameters that were fitted to this run: how the ball was set.
    pub fitted_settings: Vec<String>,
}

impl RunPrediction {
    /// True when the band holds the readings.
    pub fn holds(&self) -> bool {
        self.inside_95_fraction >= COVERED
    }
}
