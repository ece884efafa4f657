//! A run that has ended, whose journals are still to be rewritten: again where the disk refuses.

use crate::error::RecordError;
use crate::finish::{Ending, FinishedFile, finish_journal};
use std::path::PathBuf;
use trunnion_core::Gap;

/// The journals of a run that has ended.
pub struct Closed {
    journals: Vec<PathBuf>,
    /// What could not be written; the last file says so.
    lost: Option<Gap>,
    finished: Finished,
}

/// The result of a run that was recorded to its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    /// The finished files; more than one when the disk was full in between.
    pub files: Vec<FinishedFile>,
    /// Samples that could not be written.
    pub lost_samples: u64,
}

impl Closed {
    pub(super) fn new(journals: Vec<PathBuf>, lost: Option<Gap>, lost_samples: u64) -> Self {
        Self { journals, lost, finished: Finished { files: Vec::new(), lost_samples } }
    }

    /// Rewrites the journals that are left.
    ///
    /// # Errors
    /// When a file cannot be written or does not read back; its journal is kept, and this may be called again.
    pub fn finish(&mut self) -> Result<Finished, RecordError> {
        while let Some(journal) = self.journals.get(self.finished.files.len()) {
            let is_last = self.finished.files.len() + 1 == self.journals.len();
            let lost = self.lost.as_ref().filter(|_| is_last);
            self.finished.files.push(finish_journal(journal, Ending::Ended(lost))?);
        }
        Ok(self.finished.clone())
    }
}
