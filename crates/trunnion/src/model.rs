//! A model with the text of its file, so that what a person wrote into it stays.

use crate::{Error, files};
use std::ffi::OsStr;
use std::path::Path;
use trunnion_cycles::Run;
use trunnion_effects as effects;
use trunnion_effects::{LadderRow, ModelEffect, Removal};
use trunnion_machine::Machine;
use trunnion_results as results;

/// Name of a model without a file in problems of its text.
const EDITED: &str = "model";

/// The effects that explain a machine, in the order they were added (`trunnion-model/1`).
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    entries: effects::Model,
    text: String,
    /// The file that its entries stand in, for problems; `None` where they stand in none.
    file: Option<String>,
}

impl Model {
    /// Location errors and ball setting alone.
    pub fn base(machine: &str) -> Self {
        effects::Model::base(machine).into()
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// A file that cannot be read; every problem of the file.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        Self::parse(&path.display().to_string(), files::read(path)?)
    }

    /// Reads a model file; the base model where there is none yet.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn load_or_base(path: impl AsRef<Path>, machine: &str) -> Result<Self, Error> {
        if path.as_ref().exists() { Self::load(path) } else { Ok(Self::base(machine)) }
    }

    /// Reads the text of a model file; `file` is the name in problems.
    ///
    /// # Errors
    /// Every problem of the text.
    pub fn parse(file: &str, text: String) -> Result<Self, Error> {
        Ok(Self { entries: effects::Model::parse(file, &text)?, text, file: Some(file.into()) })
    }

    /// Writes the model file whole or not at all; comments of the file it was read from stay.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        files::write_whole(path.as_ref(), &self.text)
    }

    /// Ids of the effects, in order.
    pub fn effects(&self) -> Vec<&str> {
        self.entries.effects.iter().map(|entry| entry.id.as_str()).collect()
    }

    /// Name of its machine, as runs call it: of a path that of the file.
    pub fn machine(&self) -> &str {
        let named = &self.entries.machine;
        let file = named.strip_suffix(".toml").map(Path::new).and_then(Path::file_name);
        file.and_then(OsStr::to_str).unwrap_or(named)
    }

    /// The ladder: what adding each effect did.
    pub fn ladder(&self) -> results::Ladder {
        (&self.entries).into()
    }

    /// The entries as the engine takes them.
    pub fn entries(&self) -> &effects::Model {
        &self.entries
    }

    /// The text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Why its effects may not be those of runs of a machine of this name: the file names another.
    pub fn doubt_for(&self, machine: &str) -> Option<results::Doubt> {
        let machines = [self.machine(), machine];
        (machines[0] != machines[1]).then(|| results::Doubt::other_machine(machines))
    }

    /// Refuses entries of a file that the machine cannot have, each with its line.
    pub(crate) fn suits(&self, machine: &Machine) -> Result<(), Error> {
        match &self.file {
            None => Ok(()),
            Some(file) => Ok(effects::Model::check(file, &self.text, machine)?),
        }
    }

    /// Refuses runs of a machine that is not that of the file.
    pub(crate) fn is_of(&self, runs: &[Run]) -> Result<(), Error> {
        match runs.iter().find(|run| run.machine.name != self.machine()) {
            None => Ok(()),
            Some(run) => Err(Error::ModelOfOtherMachine {
                model: self.machine().into(),
                run: run.name.clone(),
                found: run.machine.name.clone(),
            }),
        }
    }

    /// Of an edited text, which is read again so that the model always is what its file will hold.
    fn edited(text: String) -> Result<Self, Error> {
        Ok(Self { file: None, ..Self::parse(EDITED, text)? })
    }

    /// Of a text with the same entries: they stand where they stood.
    pub(crate) fn with_same_entries(&self, text: String) -> Result<Self, Error> {
        Ok(Self { file: self.file.clone(), ..Self::edited(text)? })
    }

    /// With more entries at the end.
    pub(crate) fn with(&self, entries: &[ModelEffect]) -> Result<Self, Error> {
        let text =
            entries.iter().try_fold(self.text.clone(), |text, entry| effects::Model::append(&text, entry))?;
        Self::edited(text)
    }

    /// With another ladder row of the entry `id`.
    pub(crate) fn with_ladder_row(&self, id: &str, row: &LadderRow) -> Result<Self, Error> {
        self.with_same_entries(effects::Model::with_ladder_row(&self.text, id, row)?)
    }

    /// Without these entries, and with who took them out and when.
    pub(crate) fn without(&self, ids: &[&str], removal: &Removal) -> Result<Self, Error> {
        let text = ids.iter().try_fold(self.text.clone(), |text, id| effects::Model::without(&text, id))?;
        Self::edited(effects::Model::with_removal(&text, removal)?)
    }
}

impl From<effects::Model> for Model {
    fn from(entries: effects::Model) -> Self {
        let text = entries.to_text();
        Self { entries, text, file: None }
    }
}
