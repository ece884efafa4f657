//! The named methods that the runs of a page serve.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-methods/1`: every named method, with what keeps these runs from it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MethodList {
    /// Format and version.
    pub format: MethodListFormat,
    /// The methods.
    pub methods: Vec<MethodLine>,
}

/// Format and version of a list of methods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum MethodListFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-methods/1")]
    V1,
}

/// One method.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MethodLine {
    /// Name, as calls and commands take it.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Where the recipe comes from.
    pub source: String,
    /// What these runs lack for it; empty where it can be done.
    pub problem: String,
}
