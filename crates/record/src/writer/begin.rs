//! Journals of a run: which name each has, and how one begins.

use super::Recorder;
use super::kept::KeptJournal;
use crate::error::RecordError;
use crate::journal::Journal;
use crate::journal_file::{JOURNAL_ENDING, remove_unready};
use std::path::PathBuf;

impl Recorder {
    /// Starts a journal of the first free name, and brings its beginning to the disk: what that refuses, waits better in memory.
    pub(super) fn start_further_journal(&mut self) -> Result<Journal, RecordError> {
        let mut number = self.journals.len();
        while self.taken(number).is_some() {
            number += 1;
        }
        let mut journal = self.start_journal(number)?;
        if let Err(error) = journal.sync() {
            let path = journal.abandon();
            self.journals.pop();
            remove_unready(&path);
            return Err(error);
        }
        Ok(journal)
    }

    /// Starts the journal of this number.
    pub(super) fn start_journal(&mut self, number: usize) -> Result<Journal, RecordError> {
        std::fs::create_dir_all(&self.dir).map_err(RecordError::io("create the folder", &self.dir))?;
        let [_, path] = self.files(number);
        let file = (self.open)(&path).map_err(RecordError::io("create", &path))?;
        match Journal::start(path.clone(), file, &self.header) {
            Ok(journal) => {
                self.journals.push(KeptJournal::begin(path));
                Ok(journal)
            }
            Err(error) => {
                // A journal without its header is worth nothing.
                remove_unready(&path);
                Err(error)
            }
        }
    }

    /// The file that has the name of this journal already.
    pub(super) fn taken(&self, number: usize) -> Option<PathBuf> {
        self.files(number).into_iter().find(|path| path.exists())
    }

    /// Recording and journal of this number: `NAME.mcap`, then `NAME-2.mcap` and so on.
    fn files(&self, number: usize) -> [PathBuf; 2] {
        let name = match number {
            0 => self.name.clone(),
            n => format!("{}-{}", self.name, n + 1),
        };
        ["", JOURNAL_ENDING].map(|ending| self.dir.join(format!("{name}.mcap{ending}")))
    }
}
