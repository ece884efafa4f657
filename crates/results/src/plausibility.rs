//! Whether runs can be what they say they are.

use crate::complete::Complete;
use crate::doubt::Doubt;
use crate::number::finite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_engine as engine;

pub use trunnion_engine::plausibility::FEWEST_POINTS;

/// What is asked of runs before anything is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Question {
    /// Can they be what they say they are?
    #[default]
    Plausible,
    /// Do they hold enough of what was planned?
    Whole,
}

/// Why runs cannot be judged: something that no machine can do, or a part of the cycle that is missing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Plausibility {
    /// The question that was answered with no.
    #[serde(default)]
    pub question: Question,
    /// What is wrong, where, and how large.
    pub finding: String,
    /// The mistake that would explain it, and what to do or to repeat.
    pub hypothesis: String,
    /// Residual with the mistake undone, µm rms; null where it is no question of size.
    pub rms_um_with_it: Option<f64>,
}

/// `trunnion-check/1`: can these runs be what they say they are?
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Check {
    /// Format and version.
    pub format: CheckFormat,
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Usable points of all runs.
    pub points: usize,
    /// What is planned, read, missing and excluded.
    #[serde(default)]
    pub complete: Complete,
    /// What is not plausible or not whole; empty for good runs.
    pub plausibility: Vec<Plausibility>,
    /// Instruments of whose positions nothing is asked: they keep no known distance.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_asked: Vec<String>,
    /// What to doubt in the readings whatever is fitted to them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<Doubt>,
}

/// Format and version of a check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum CheckFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-check/1")]
    V1,
}

impl From<&engine::plausibility::Implausible> for Plausibility {
    fn from(found: &engine::plausibility::Implausible) -> Self {
        Self {
            question: Question::Plausible,
            finding: found.finding.clone(),
            hypothesis: found.hypothesis.clone(),
            rms_um_with_it: found.rms_um_with_it.and_then(finite),
        }
    }
}
