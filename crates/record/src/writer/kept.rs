//! A journal of a run, and what is in it.

use crate::error::RecordError;
use crate::journal::Journal;
use crate::journal_file::is_not_there;
use crate::lost;
use crate::wire::{Encoded, Topic};
use std::path::PathBuf;
use trunnion_core::Gap;

/// A journal that was begun.
pub(super) struct KeptJournal {
    pub path: PathBuf,
    /// Samples in it.
    pub samples: u64,
    /// Samples that the gaps in it say are missing.
    pub missing: u64,
    /// Time of the first sample, or of the first gap.
    pub from_s: Option<f64>,
    /// Time of the last one.
    pub to_s: f64,
}

impl KeptJournal {
    pub fn begin(path: PathBuf) -> Self {
        Self { path, samples: 0, missing: 0, from_s: None, to_s: f64::NEG_INFINITY }
    }

    /// True where the system says so; one that cannot be looked for may be there.
    pub fn is_gone(&self) -> bool {
        std::fs::metadata(&self.path).is_err_and(|why| is_not_there(&why))
    }

    /// A message is in it.
    pub fn wrote(&mut self, message: &Encoded) {
        if message.samples > 0 || message.topic == Topic::Gap {
            self.samples += message.samples;
            self.missing += message.missing;
            // Batches of several channels come in the order in which they are full.
            self.from_s = Some(self.from_s.map_or(message.time_s, |from_s| from_s.min(message.time_s)));
            self.to_s = self.to_s.max(message.until_s);
        }
    }

    /// What was in it is lost, and what its gaps said is said again. Without either it leaves no gap.
    pub fn lose(&self, lost: &mut Option<Gap>, reason: &str) {
        if let Some(from_s) = self.from_s {
            lost::add(lost, (from_s, self.to_s), self.samples + self.missing, reason);
        }
    }
}

/// A journal that was not at its place.
pub(super) struct Missing {
    pub kept: KeptJournal,
    /// The way to its file, wherever that is: another file may have the name by now.
    pub journal: Journal,
}

impl Missing {
    /// True unless the system says that its place is empty. Another file at its place is noticed only where ours has no name left: one
    /// that was moved elsewhere still takes what is written to it.
    pub fn is_there(&self) -> bool {
        !matches!(self.journal.sync(), Err(RecordError::Gone { .. }))
    }
}
