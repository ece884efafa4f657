//! The ladder: the effects added to a model, with the error before and after each.

use crate::identification::Identification;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_effects as effects;

pub use trunnion_effects::{LadderRow, Moved, Removal};

/// `trunnion-ladder/1`: every effect of a model, with what adding it did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Ladder {
    /// Format and version.
    pub format: LadderFormat,
    /// Entries of the model, in order.
    pub rows: Vec<LadderEntry>,
    /// Effects that were taken out again, in order.
    pub removed: Vec<Removal>,
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
    /// What adding it did; null for the effects of every model, for one written by hand, and for one that came in with another by one act:
    /// the row of that other is that of both.
    pub ladder: Option<LadderRow>,
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

impl Ladder {
    /// Id and row of every effect that was added, in order.
    pub fn added(&self) -> impl DoubleEndedIterator<Item = (&str, &LadderRow)> {
        self.rows.iter().filter_map(|entry| Some((entry.effect.as_str(), entry.ladder.as_ref()?)))
    }
}

impl From<&effects::Model> for Ladder {
    fn from(model: &effects::Model) -> Self {
        // Where a person took the first of an act out of the file, the others stand for themselves.
        let holds = |id: &String| model.effects.iter().any(|entry| entry.id == *id);
        let is_shown = |row: &LadderRow| !row.with.as_ref().is_some_and(holds);
        let entry = |entry: &effects::ModelEffect| LadderEntry {
            effect: entry.id.clone(),
            ladder: entry.ladder.clone().filter(is_shown),
        };
        let (rows, removed) = (model.effects.iter().map(entry).collect(), model.removed.clone());
        Self { format: LadderFormat::V1, rows, removed }
    }
}
