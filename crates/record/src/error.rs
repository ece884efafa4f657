//! What can go wrong with a recording.

use crate::journal_file::is_journal;
use std::path::{Path, PathBuf};
use trunnion_core::Problems;

/// Why a recording could not be made, finished or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The operating system refused.
    #[error("cannot {what} {}", path.display())]
    Io {
        /// What we were doing.
        what: &'static str,
        /// To which file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// Writing MCAP records failed.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: mcap::McapError,
    },
    /// The file that is written is not there any more.
    #[error(
        "{} is not there any more: it or its folder was removed or moved while it was recorded. What was moved is in the file at its \
         new place: put it back into the folder of the recordings after the end of the run and start the service again, which recovers it", path.display()
    )]
    Gone {
        /// The file.
        path: PathBuf,
    },
    /// A recording of this name exists.
    #[error("{} exists already; {}", path.display(), way_out(path))]
    Exists {
        /// The file in the way.
        path: PathBuf,
    },
    /// Another ending than that of recordings.
    #[error("the name of a recording ends in .mcap: write {}", better.display())]
    Ending {
        /// As asked.
        path: PathBuf,
        /// The same with the ending.
        better: PathBuf,
    },
    /// Nothing of the file can be read.
    #[error("{} is not a recording: at byte {offset}, {reason}", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
        /// Where reading stopped.
        offset: u64,
        /// Why.
        reason: String,
    },
    /// The finished file differs from the journal it was made from; the journal is kept.
    #[error("{} does not read back as it was written ({reason}); the journal next to it is kept", path.display())]
    Verify {
        /// The rewritten file.
        path: PathBuf,
        /// What differs.
        reason: String,
    },
    /// The machine of the recording is not known.
    #[error("{}: machine \"{name}\" is neither in the recording nor known; add its file to config/machines", path.display())]
    UnknownMachine {
        /// The recording.
        path: PathBuf,
        /// The name it gives.
        name: String,
    },
    /// The machine file inside the recording has problems.
    #[error("the recorded machine file cannot be used")]
    Machine(#[source] Problems),
    /// The writer thread has ended.
    #[error("the recorder has stopped; see the log for why")]
    Stopped,
}

/// What to do about a file that is in the way: a journal holds samples that nothing else has.
fn way_out(path: &Path) -> &'static str {
    match is_journal(path) {
        true => {
            "it is of a run that was not finished: start the service, which recovers it, or choose another name"
        }
        false => "choose another name, or remove it",
    }
}

impl RecordError {
    /// True where the disk or its folder refused, which a person may mend: what is in memory is worth keeping until then.
    pub fn may_pass(&self) -> bool {
        matches!(self, Self::Io { .. } | Self::Write { source: mcap::McapError::Io(_), .. })
    }

    /// What remains to be said where the file was named already.
    #[must_use]
    pub fn without_file(self) -> Box<dyn std::error::Error + Send + Sync> {
        match self {
            Self::Io { source, .. } | Self::Write { source: mcap::McapError::Io(source), .. } => {
                source.into()
            }
            Self::Write { source, .. } => source.into(),
            Self::NotARecording { offset, reason, .. } => {
                format!("it is no recording: at byte {offset}, {reason}").into()
            }
            other => other.into(),
        }
    }

    pub(crate) fn io(what: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::Io { what, path: path.into(), source }
    }

    pub(crate) fn write(path: &Path) -> impl FnOnce(mcap::McapError) -> Self {
        move |source| Self::Write { path: path.into(), source }
    }
}
