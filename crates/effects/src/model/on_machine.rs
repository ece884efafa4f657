//! Which entries of a model file a machine cannot have, with the line of each.

use super::{Model, read_effect};
use crate::formula::FormulaError;
use crate::{Instance, UnknownEffect};
use trunnion_core::Problems;
use trunnion_core::input::{Document, Table};
use trunnion_machine::Machine;

impl Model {
    /// Looks for effects in the text of a model file that this machine cannot have, and for expressions that cannot be read.
    ///
    /// # Errors
    /// All of them, each with its line.
    pub fn check(file: &str, text: &str, machine: &Machine) -> Result<(), Problems> {
        let document = Document::parse(file, text)?;
        for table in document.root().tables("effect") {
            let entry = read_effect(&table);
            if let Some(Err(error)) = entry.map(|entry| Instance::from_model_effect(&entry, machine)) {
                note(&table, &error);
            }
        }
        document.finish(Some(()))
    }
}

fn note(table: &Table<'_>, error: &UnknownEffect) {
    match error {
        UnknownEffect::Id { id, machine, allowed } => {
            let found = format!("= \"{id}\" is no effect of machine {machine}");
            table.problem("id", found, format!("{allowed}, formula:NAME"), "");
        }
        UnknownEffect::Formula { error: FormulaError::Key { key, found, allowed }, .. } => {
            table.problem(key, format!("is {found}"), allowed, "");
        }
        UnknownEffect::Formula { error, .. } => {
            let text = error.to_string();
            let why = text.strip_prefix("expression, ").unwrap_or(&text);
            table.problem("expression", format!("cannot be read: {why}"), "", "");
        }
    }
}
