//! A parameter of the machine in two runs.

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
