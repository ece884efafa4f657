//! What the next day of a machine is expected to show.

use crate::prediction::RunPrediction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-forecast/1`: what one more day of an unchanged machine is expected to show, by the frozen values of the days before; or why
/// nothing is expected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DayForecast {
    /// Format and version.
    pub format: ForecastFormat,
    /// Runs whose values are frozen, oldest first.
    pub runs: Vec<String>,
    /// Lowest and highest temperature of these runs, °C; null where none was recorded.
    pub temperature_degc: Option<[f64; 2]>,
    /// How the runs before the last predict the last, which took no part in their fit; null where that could not be asked.
    pub checked: Option<RunPrediction>,
    /// Half width of the 95 % band of a reading of the same cycle, µm (rms over the readings); null where nothing is expected.
    pub band_95_um: Option<f64>,
    /// Values of the machine in one more run; empty where nothing is expected.
    pub values: Vec<ForecastValue>,
    /// Why nothing is expected; empty where something is.
    pub why_not: String,
    /// The same in sentences.
    pub words: Vec<String>,
}

/// Format and version of a forecast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ForecastFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-forecast/1")]
    V1,
}

/// A value of the machine in one more run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForecastValue {
    /// Id of its effect.
    pub effect: String,
    /// Name of the parameter.
    pub name: String,
    /// What it is, for a person; the name where there are no words for it.
    pub words: String,
    /// Its unit.
    pub unit: String,
    /// Expected value.
    pub value: f64,
    /// Standard uncertainty in one more run: that of the mean, and what differs from run to run.
    pub u: f64,
}
