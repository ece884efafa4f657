//! Whether runs can be what they say they are.

use crate::number::finite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_engine as engine;

/// Something in the runs that no machine can do.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Plausibility {
    /// What is wrong, where, and how large.
    pub finding: String,
    /// The mistake that would explain it, and what to do.
    pub hypothesis: String,
    /// What is left with the mistake undone, µm rms; null where it is no question of size.
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
    /// What is not plausible; empty for good runs.
    pub plausibility: Vec<Plausibility>,
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
            finding: found.finding.clone(),
            hypothesis: found.hypothesis.clone(),
            rms_um_with_it: found.rms_um_with_it.and_then(finite),
        }
    }
}
