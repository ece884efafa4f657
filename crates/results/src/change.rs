//! A parameter of the machine in two runs.

use crate::identification::Parameter;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A parameter in two runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChangedParameter {
    /// Id of its effect.
    pub effect: String,
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Value in the earlier run.
    pub before: f64,
    /// Value in the later run.
    pub after: f64,
    /// Later − earlier.
    pub difference: f64,
    /// Standard uncertainty of the difference of two independent runs.
    pub u: f64,
    /// True when the difference is significant.
    pub changed: bool,
}

impl Parameter {
    /// True where both values are of one thing: a parameter that stands for others does so in both.
    pub fn is_comparable(&self, other: &Self) -> bool {
        (&self.effect, &self.name, &self.note) == (&other.effect, &other.name, &other.note)
    }
}
