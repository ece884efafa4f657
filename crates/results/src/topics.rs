//! What the service publishes next to its status: the disk and what was removed from it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A value that is published under a name of its own.
pub trait Published: Serialize {
    /// The name, below `trunnion/<machine>/`.
    const TOPIC: &'static str;
    /// The name of its schema.
    const SCHEMA: &'static str = Self::TOPIC;
}

/// The topic `storage`: the disk of the recordings and their recorder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct StorageNow {
    /// How it is.
    pub state: StorageState,
    /// Why it is offline; null while the service runs.
    pub reason: Option<String>,
    /// Free for the service, MB; null where the system does not say.
    pub free_mb: Option<f64>,
    /// Why it is not good; null when it is.
    pub why: Option<String>,
    /// Samples of the newest run that were lost as they could not be written.
    pub lost_samples: u64,
    /// Runs of the folder whose samples are there.
    pub runs: usize,
    /// Runs whose samples were removed to make room; their reports stay.
    pub removed: usize,
    /// Why nothing is removed at present, or not all that should be; null when there is nothing to say.
    pub not_removed: Option<String>,
}

impl Published for StorageNow {
    const TOPIC: &'static str = "storage";
}

/// How the disk of the recordings is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StorageState {
    /// The service does not run.
    #[default]
    Offline,
    /// There is room, and what is recorded is written.
    Good,
    /// Less is free than is to be kept free, or than the last cycle would have needed.
    Low,
    /// What is recorded cannot be written at present.
    Failing,
}

impl StorageState {
    /// Its name on every surface.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Offline => "offline",
            Self::Good => "good",
            Self::Low => "low",
            Self::Failing => "failing",
        }
    }
}

/// The topic `removed`: the recording that was removed last. Its report stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct SamplesRemoved {
    /// Name of its run.
    pub run: String,
    /// What it took, MB.
    pub mb: f64,
    /// Why it was removed.
    pub why: String,
}

impl Published for SamplesRemoved {
    const TOPIC: &'static str = "removed";
    const SCHEMA: &'static str = "samples-removed";
}
