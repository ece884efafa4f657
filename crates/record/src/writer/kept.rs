//! A journal of a run, and what is in it.

use crate::wire::Encoded;
use std::path::PathBuf;

/// A journal that was begun.
pub(super) struct KeptJournal {
    pub path: PathBuf,
    /// Samples in it.
    pub samples: u64,
    /// Time of its first message with samples.
    pub from_s: Option<f64>,
    /// Time of its last one.
    pub to_s: f64,
}

impl KeptJournal {
    pub fn begin(path: PathBuf) -> Self {
        Self { path, samples: 0, from_s: None, to_s: f64::NEG_INFINITY }
    }

    /// True where the system says so; one that cannot be looked for may be there.
    pub fn is_gone(&self) -> bool {
        self.path.try_exists().is_ok_and(|is_there| !is_there)
    }

    /// A message is in it.
    pub fn wrote(&mut self, message: &Encoded) {
        if message.samples > 0 {
            self.samples += message.samples;
            self.from_s.get_or_insert(message.time_s);
            self.to_s = self.to_s.max(message.time_s);
        }
    }
}
