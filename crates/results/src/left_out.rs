//! What tables and figures of a model do not hold.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_methods::NotTabulated;

/// An effect that is not in the figures, or only partly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOutEffect {
    /// Effect id.
    pub effect: String,
    /// Why.
    pub why: String,
}

impl From<&NotTabulated> for LeftOutEffect {
    fn from(left_out: &NotTabulated) -> Self {
        Self { effect: left_out.effect.clone(), why: left_out.why.clone() }
    }
}
