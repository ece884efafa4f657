//! The main job on the simulator.

use crate::diagnosis::{Diagnosis, Verdict};
use crate::identification::Identification;
use crate::ladder::LadderRow;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-demo/1`: a simulated machine with a hidden effect, measured, identified, diagnosed and corrected.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Demo {
    /// Format and version.
    pub format: DemoFormat,
    /// Seed of everything random.
    pub seed: u64,
    /// Ids of the hidden physics.
    pub hidden: Vec<String>,
    /// Ids of the effects that were added.
    pub found: Vec<String>,
    /// Verdict of the first diagnosis.
    pub verdict: Verdict,
    /// Diagnosis of the base model.
    pub diagnosis: Diagnosis,
    /// The effects added, in order.
    pub ladder: Vec<DemoStep>,
    /// The last fit.
    pub identification: Identification,
    /// Diagnosis of the last model.
    pub last_diagnosis: Diagnosis,
    /// The last model on the on-the-fly run; null where that was left out.
    pub on_the_fly: Option<Identification>,
    /// Path of the report.
    pub report: String,
    /// What was lost while recording.
    pub losses: Vec<String>,
    /// Why it was lost, as far as a measured pause of the computer shows; empty when nothing was.
    #[serde(default)]
    pub why_lost: String,
}

/// Format and version of a demo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum DemoFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-demo/1")]
    V1,
}

/// What adding one effect did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DemoStep {
    /// Effect id.
    pub effect: String,
    /// Residual before, µm rms.
    pub error_before_um: f64,
    /// Residual after, µm rms.
    pub error_after_um: f64,
    /// Held-out error before, µm rms; null where nothing can be left out.
    pub holdout_before_um: Option<f64>,
    /// Held-out error after, µm rms; null where nothing can be left out.
    pub holdout_after_um: Option<f64>,
}

impl DemoStep {
    /// The errors of a row of the ladder.
    pub fn new(effect: &str, row: &LadderRow) -> Self {
        Self {
            effect: effect.into(),
            error_before_um: row.error_before_um,
            error_after_um: row.error_after_um,
            holdout_before_um: row.holdout_before_um,
            holdout_after_um: row.holdout_after_um,
        }
    }
}
