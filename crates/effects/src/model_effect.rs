//! An entry of a model, and what adding it did.

use crate::FittedValues;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One `[[effect]]` of a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelEffect {
    /// Effect id.
    pub id: String,
    /// Shape numbers (inside units), where the effect has some; empty: the fit chooses on the grid.
    pub shape: Vec<f64>,
    /// Parameters held at a value (screen units) by name.
    pub fixed: Vec<(String, f64)>,
    /// What is known of parameters beforehand (screen units) by name.
    pub prior: Vec<(String, Prior)>,
    /// Where a formula acts: `axis:B`, `ball`, `spindle` or `reading`.
    pub site: Option<String>,
    /// Component of a formula: `dx` … `ec`.
    pub component: Option<String>,
    /// Expression of a formula.
    pub expression: Option<String>,
    /// Grid of the non-linear parameters of a formula (inside units) by name.
    pub grid: Vec<(String, Vec<f64>)>,
    /// What adding it did.
    pub ladder: Option<LadderRow>,
    /// Values of the whole model from the fit of its adding.
    pub values: Option<FittedValues>,
}

impl ModelEffect {
    /// Id of the entry that it was added with, its own where it was added alone.
    pub fn added_as(&self) -> &str {
        self.ladder.as_ref().and_then(|row| row.with.as_deref()).unwrap_or(&self.id)
    }
}

/// A value known beforehand with its standard uncertainty, screen units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Expected value.
    pub value: f64,
    /// Standard uncertainty, above zero.
    pub u: f64,
}

/// What adding an effect did to the error; before and after are of the same data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LadderRow {
    /// Day, `YYYY-MM-DD`; may be empty.
    pub date: String,
    /// Who added it; left out where nobody gave a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// Id of the entry that it came in with, by one act: a formula of several components is one entry for each. The row of that entry is
    /// that of all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with: Option<String>,
    /// Runs it was fitted to; may be empty.
    pub run: String,
    /// Residual of the fit before, µm rms.
    pub error_before_um: f64,
    /// Residual of the fit after, µm rms.
    pub error_after_um: f64,
    /// Held-out error before, µm rms.
    pub holdout_before_um: Option<f64>,
    /// Held-out error after, µm rms.
    pub holdout_after_um: Option<f64>,
    /// The unit that was left out in turn: `run`, `setup`, `pass` or `block`.
    #[serde(default)]
    pub holdout_unit: Option<String>,
    /// Repeatability of a reading, µm; null where no pose was measured twice.
    pub noise_um: Option<f64>,
    /// Parameters of the effects before it that moved when it came in, most moved first.
    pub moved: Vec<Moved>,
    /// log10 of the Bayes factor against noise only with which a diagnosis proposed it then; null where none did, and in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<f64>,
    /// Ids of the effects that the data did not distinguish from it then.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub confused_with: Vec<String>,
    /// The measurement that separates them; empty where it was confused with none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub separate_by: String,
    /// Ids of effects that the model held when that was found, and that were taken out of it since.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub found_with: Vec<String>,
}

impl LadderRow {
    /// The row of an effect that was measured again: who added it, and what was found for it when it was added.
    #[must_use]
    pub fn again(self, was: Self) -> Self {
        let Self { by, evidence, confused_with, separate_by, found_with, .. } = was;
        Self { by, evidence, confused_with, separate_by, found_with, ..self }
    }

    /// True where a diagnosis said something for it.
    pub fn was_found(&self) -> bool {
        self.evidence.is_some() || !self.confused_with.is_empty()
    }
}

/// A parameter that moved when an effect came in: it had absorbed a part of what was missing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Moved {
    /// Parameter name.
    pub name: String,
    /// Value without the effect, in `unit`.
    pub before: f64,
    /// Value with it.
    pub after: f64,
    /// Standard uncertainty with the effect in the model: without it, what it does counts as noise.
    pub u: f64,
    /// Unit on files and screens, e.g. `um`.
    pub unit: String,
}

impl Moved {
    /// Change in units of the standard uncertainty.
    pub fn in_u(&self) -> f64 {
        (self.after - self.before).abs() / self.u.max(f64::MIN_POSITIVE)
    }
}
