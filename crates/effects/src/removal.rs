//! Who took an effect out of a model, and when: `[[removed]]` of a model file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml_edit::{Table as Written, value};
use trunnion_core::input::Table;

/// An effect that is no longer in the model.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Removal {
    /// Effect id.
    pub effect: String,
    /// Day, `YYYY-MM-DD`.
    pub date: String,
    /// Who removed it; left out where nobody gave a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
}

impl Removal {
    pub(crate) fn read(table: &Table<'_>) -> Option<Self> {
        let (effect, date, by) = (table.string("effect"), table.string("date"), table.optional_string("by"));
        table.no_other_keys();
        Some(Self { effect: effect?, date: date?, by })
    }

    pub(crate) fn written(&self) -> Written {
        let mut table = Written::new();
        table["effect"] = value(&self.effect);
        table["date"] = value(&self.date);
        if let Some(by) = &self.by {
            table["by"] = value(by);
        }
        table
    }
}
