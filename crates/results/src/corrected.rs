//! Corrections that a person entered into the control, and the runs before and after each.

use crate::change::ChangedParameter;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A correction, from the moment when it was entered into the control.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CorrectionEntered {
    /// Name of the machine.
    pub machine: String,
    /// When, s since 1970 UTC.
    pub at_s: i64,
    /// The same for a person.
    pub at: String,
    /// Who entered it.
    pub by: String,
    /// What was entered.
    pub what: String,
}

/// The last run before a correction and the first after it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AroundCorrection {
    /// The correction.
    pub correction: CorrectionEntered,
    /// The last run before it; null where there is none.
    pub before: Option<String>,
    /// The first run after it; null until one is analysed.
    pub after: Option<String>,
    /// Every parameter of the machine that both determine, most changed first.
    pub parameters: Vec<ChangedParameter>,
    /// The same in sentences.
    pub words: Vec<String>,
}

impl CorrectionEntered {
    /// The corrections of a file that has one on each line; the number of a line that is none and why otherwise.
    ///
    /// # Errors
    /// A line that is no correction.
    pub fn of_lines(text: &str) -> Result<Vec<Self>, (usize, serde_json::Error)> {
        let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
        lines.map(|(at, line)| serde_json::from_str(line).map_err(|why| (at + 1, why))).collect()
    }
}
