//! A step of setting up at the machine while a person does it, for the page and MQTT.

use crate::topics::Published;
use crate::{NestCalibrated, SignTest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-set-up/1`: which step is under way, what was seen, what comes next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SetUpState {
    /// Format and version.
    pub format: SetUpFormat,
    /// The step; null while none is under way.
    pub step: Option<SetUpStep>,
    /// How often the machine has dwelt since the step began.
    pub dwells: usize,
    /// The last of them in words; empty before the first.
    pub last: String,
    /// What the jogs say so far; null before the first.
    pub sign_test: Option<SignTest>,
    /// The calibrated nest; null before it is.
    pub nest: Option<NestCalibrated>,
    /// Where the calibrated nest was written, and what stays of the file before; empty before it is.
    pub written: String,
    /// Why the last step gave no answer; empty otherwise.
    pub problem: String,
    /// The next thing to do.
    pub to_do: String,
}

impl Published for SetUpState {
    const TOPIC: &'static str = "set-up";
}

/// Format and version of a step of setting up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SetUpFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-set-up/1")]
    V1,
}

/// A step of setting up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SetUpStep {
    /// Directions of the probes from known steps.
    Nest,
    /// Whether the probes follow jogs.
    SignTest,
}
