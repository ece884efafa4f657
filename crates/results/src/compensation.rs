//! What a file of compensation tables holds.

use crate::axis_errors::AxisErrors;
use crate::left_out::LeftOutEffect;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-compensation-summary/1`: what was written for the control, and what is not in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CompensationSummary {
    /// Format and version.
    pub format: CompensationFormat,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs that the model was fitted to.
    pub runs: Vec<String>,
    /// Sign of the values.
    pub values: CompensationValues,
    /// Ids of the effects that are in the tables.
    pub holds: Vec<String>,
    /// Effects that are not.
    pub left_out: Vec<LeftOutEffect>,
    /// The tables.
    pub axes: Vec<CompensationAxis>,
    /// The file that was written.
    pub written: String,
}

/// Format and version of a compensation summary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum CompensationFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-compensation-summary/1")]
    V1,
}

/// Sign of compensation values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CompensationValues {
    /// actual − nominal.
    Error,
    /// −error.
    Correction,
}

impl CompensationValues {
    /// What an error is multiplied by to become such a value.
    pub fn sign(self) -> f64 {
        match self {
            Self::Error => 1.0,
            Self::Correction => -1.0,
        }
    }
}

/// The table of one axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CompensationAxis {
    /// The axis.
    pub axis: String,
    /// Rows.
    pub rows: usize,
    /// True when the table is a whole turn.
    pub whole_turn: bool,
}

impl CompensationSummary {
    /// What was written of these errors, and where.
    pub fn new(errors: &AxisErrors, values: CompensationValues, written: String) -> Self {
        Self {
            format: CompensationFormat::V1,
            machine: errors.machine.clone(),
            runs: errors.runs.clone(),
            values,
            holds: errors.effects.clone(),
            left_out: errors.left_out.clone(),
            axes: errors
                .axes
                .iter()
                .map(|table| CompensationAxis {
                    axis: table.axis.clone(),
                    rows: table.positions.len(),
                    whole_turn: table.whole_turn,
                })
                .collect(),
            written,
        }
    }
}
