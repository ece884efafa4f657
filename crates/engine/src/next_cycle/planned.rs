//! The cycle that was chosen, as a diagnosis carries it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
