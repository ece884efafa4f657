//! Why the service, or one cycle of it, failed.

use crate::live::PlanError;
use crate::storage::LockError;
use std::path::PathBuf;
use trunnion_record::RecordError;

/// Why the service, or one cycle of it, failed.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// An answer that JSON cannot hold.
    #[error("cannot write an answer as JSON")]
    Json(#[from] serde_json::Error),
    /// The cycle cannot be measured with these devices.
    #[error("the cycle cannot be measured")]
    Plan(#[from] PlanError),
    /// The recording failed.
    #[error("recording failed")]
    Record(#[from] RecordError),
    /// The folder of the recordings is another's.
    #[error(transparent)]
    Folder(#[from] LockError),
    /// The writing thread could not be started.
    #[error("cannot start the recording thread")]
    Thread(#[source] std::io::Error),
    /// A result could not be written.
    #[error(transparent)]
    File(Box<trunnion::Error>),
    /// The process of an analysis could not be started.
    #[error("cannot start the process of an analysis")]
    Analyst(#[source] std::io::Error),
    /// The analysis failed.
    #[error("analysing {path} failed")]
    Analysis {
        /// The recording.
        path: PathBuf,
        /// Why.
        source: Box<trunnion::Error>,
    },
    /// A part of the service panicked.
    #[error("the {0} ended badly; this is a defect of the program")]
    Broken(&'static str),
}

impl From<trunnion::Error> for ServiceError {
    fn from(failure: trunnion::Error) -> Self {
        Self::File(Box::new(failure))
    }
}
