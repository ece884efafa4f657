//! The topic `alarms`: what of the newest run lies outside the limits that the runs before it set.

use crate::topics::Published;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Watched values of the newest run that was judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct AlarmsNow {
    /// Name of the run; null before the first.
    pub run: Option<String>,
    /// How many of its values have limits; 0 before the third run of a machine, and where limits begin again: after a correction or a change of the model.
    pub watched: usize,
    /// Those outside their limits; none is no alarm.
    pub alarms: Vec<Alarm>,
}

impl Published for AlarmsNow {
    const TOPIC: &'static str = "alarms";
}

/// A value outside its limits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Alarm {
    /// Name of the watched value: of the parameter, with its effect where parameters of several have that name; or `rms`.
    pub name: String,
    /// Id of its effect; empty for the residual.
    pub effect: String,
    /// What it is, for a person.
    pub words: String,
    /// Unit of the numbers.
    pub unit: String,
    /// The value.
    pub value: f64,
    /// Its standard uncertainty; 0 where it has none.
    pub u: f64,
    /// Mean of the runs before.
    pub mean: f64,
    /// The lower limit that they set.
    pub low: f64,
    /// The upper limit that they set.
    pub high: f64,
    /// Name of the run since which it has been outside, run after run.
    pub since: String,
}
