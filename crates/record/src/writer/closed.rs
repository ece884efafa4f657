//! A run that has ended, whose journals are still to be rewritten: again where the disk refuses.

use super::kept::KeptJournal;
use crate::error::RecordError;
use crate::finish::{Ending, FinishedFile, SyncFolder, remove_journal, rewrite_again, rewrite_journal};
use crate::journal_file::sync_folder;
use trunnion_core::Gap;

/// The journals of a run that has ended.
pub struct Closed {
    journals: Vec<KeptJournal>,
    /// What could not be written; the last file says so.
    lost: Option<Gap>,
    /// The next file of those finished: its journal is still to be removed.
    renamed: Option<Renamed>,
    finished: Finished,
}

/// A file that is written, with its journal still there.
struct Renamed {
    file: FinishedFile,
    /// What it says was lost.
    said: Option<Gap>,
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
    pub(super) fn new(journals: Vec<KeptJournal>, lost: Option<Gap>, lost_samples: u64) -> Self {
        Self { journals, lost, renamed: None, finished: Finished { files: Vec::new(), lost_samples } }
    }

    /// Rewrites the journals that are left. What was in one that is gone is lost, and costs the others nothing.
    ///
    /// # Errors
    /// When a file cannot be written or does not read back; its journal is kept, and this may be called again. `Gone` when no file
    /// is left.
    pub fn finish(&mut self) -> Result<Finished, RecordError> {
        self.finish_with(&sync_folder)
    }

    /// The same where names are brought to the disk like this.
    pub(super) fn finish_with(&mut self, sync_folder: &SyncFolder<'_>) -> Result<Finished, RecordError> {
        // Before the last file is written, which says what was lost. One that has its finished file is needed no more.
        let mut index = self.finished.files.len() + usize::from(self.renamed.is_some());
        let mut last_gone = None;
        while let Some(journal) = self.journals.get(index) {
            match journal.is_gone() {
                true => last_gone = Some(self.lose(index)),
                false => index += 1,
            }
        }
        while let Some(journal) = self.journals.get(self.finished.files.len()) {
            let is_last = self.finished.files.len() + 1 == self.journals.len();
            let lost = self.lost.as_ref().filter(|_| is_last);
            let rewritten = match &self.renamed {
                // It became the last: what was lost since stands in no other.
                Some(Renamed { file, said }) if said.as_ref() != lost && !journal.is_gone() => {
                    rewrite_again(&journal.path, &file.path, Ending::Ended(lost))
                }
                Some(Renamed { file, .. }) => Ok(file.clone()),
                None => rewrite_journal(&journal.path, Ending::Ended(lost)),
            };
            let file = match rewritten {
                Ok(file) => file,
                Err(RecordError::Gone { .. }) if self.renamed.is_none() => {
                    last_gone = Some(self.lose(self.finished.files.len()));
                    continue;
                }
                Err(error) => return Err(error),
            };
            if let Err(error) = remove_journal(&journal.path, &file.path, sync_folder) {
                self.renamed = Some(Renamed { file, said: lost.cloned() });
                return Err(error);
            }
            self.renamed = None;
            self.finished.files.push(file);
        }
        match last_gone {
            Some(gone) if self.finished.files.is_empty() => Err(gone),
            Some(_) | None => Ok(self.finished.clone()),
        }
    }

    /// A journal that is gone: its samples are lost.
    fn lose(&mut self, index: usize) -> RecordError {
        let journal = self.journals.remove(index);
        let gone = RecordError::Gone { path: journal.path.clone() };
        tracing::error!(samples = journal.samples, "{gone}");
        self.finished.lost_samples += journal.samples;
        journal.lose(&mut self.lost, &gone.to_string());
        gone
    }
}
