//! The ladder: the effects added to a model, with the error before and after each.

use crate::identification::Identification;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects as effects;

/// `trunnion-ladder/1`: every effect of a model, with what adding it did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ladder {
    /// Format and version.
    pub format: LadderFormat,
    /// Entries of the model, in order.
    pub rows: Vec<LadderEntry>,
}

/// Format and version of a ladder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LadderFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-ladder/1")]
    V1,
}

/// One effect of the model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LadderEntry {
    /// Effect id.
    pub effect: String,
    /// What adding it did; null for the effects of every model and for one written by hand.
    pub ladder: Option<LadderRow>,
}

/// What adding an effect did to the error; before and after are of the same data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LadderRow {
    /// Day, `YYYY-MM-DD`; may be empty.
    pub date: String,
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
    /// Parameters of the effects before it that moved, most moved first.
    pub moved: Vec<Moved>,
}

/// A parameter that moved when an effect came in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Moved {
    /// Name of the parameter.
    pub name: String,
    /// Value without the effect, in `unit`.
    pub before: f64,
    /// Value with it.
    pub after: f64,
    /// Standard uncertainty with it.
    pub u: f64,
    /// Unit, e.g. `um`.
    pub unit: String,
}

/// The answer of `add`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Added {
    /// Effect id.
    pub effect: String,
    /// The model file.
    pub model: String,
    /// Its ladder row.
    #[serde(flatten)]
    pub row: LadderRow,
    /// The fit with it.
    pub identification: Identification,
}

/// The answer of `remove`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Removed {
    /// Effect id.
    pub removed: String,
    /// The model file.
    pub model: String,
    /// Ids of the effects that the model still holds.
    pub effects: Vec<String>,
    /// The fit without it.
    pub identification: Identification,
}

impl Moved {
    /// Change in units of the standard uncertainty.
    pub fn in_u(&self) -> f64 {
        (self.after - self.before).abs() / self.u.max(f64::MIN_POSITIVE)
    }
}

impl From<&effects::Model> for Ladder {
    fn from(model: &effects::Model) -> Self {
        let entry = |entry: &effects::ModelEffect| LadderEntry {
            effect: entry.id.clone(),
            ladder: entry.ladder.as_ref().map(LadderRow::from),
        };
        Self { format: LadderFormat::V1, rows: model.effects.iter().map(entry).collect() }
    }
}

impl From<&effects::LadderRow> for LadderRow {
    fn from(row: &effects::LadderRow) -> Self {
        Self {
            date: row.date.clone(),
            run: row.run.clone(),
            error_before_um: row.error_before_um,
            error_after_um: row.error_after_um,
            holdout_before_um: row.holdout_before_um,
            holdout_after_um: row.holdout_after_um,
            holdout_unit: row.holdout_unit.clone(),
            noise_um: row.noise_um,
            moved: row.moved.iter().map(Moved::from).collect(),
        }
    }
}

impl From<&effects::Moved> for Moved {
    fn from(moved: &effects::Moved) -> Self {
        let effects::Moved { name, before, after, u, unit } = moved.clone();
        Self { name, before, after, u, unit }
    }
}
