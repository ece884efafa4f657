//! The cycle that was chosen, as a diagnosis carries it, and what for.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a cycle is planned for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Goal {
    /// To separate effects that explain the present data equally well.
    Separate,
    /// To show effects that the present cycle does not show.
    Reveal,
    /// To measure the present poses once more: the present data decide nothing.
    Repeat,
}

/// A cycle that separates effects, or repeats the present one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PlannedCycle {
    /// Its name.
    pub name: String,
    /// What it does.
    pub what: String,
    /// Machine time with mounting, min.
    pub minutes: f64,
    /// log₁₀ of the expected Bayes factor between the hardest pair in the present data; null where it separates no pair.
    pub separation_before: Option<f64>,
    /// The same after the cycle.
    pub separation: Option<f64>,
    /// Pairs of effects that it separates.
    pub separates: Vec<[String; 2]>,
    /// The cycle file, `trunnion-cycle/1`.
    pub file: String,
}
