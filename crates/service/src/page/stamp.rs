//! Whether a file is the one that was read.

use crate::run_record;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Changes when a file does.
pub type Stamp = Option<(SystemTime, u64)>;

/// Of a file as it is now; `None` where there is none.
pub fn stamp(path: &Path) -> Stamp {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}

/// The model file that belongs to a recording alone.
pub fn own_model(recording: &Path) -> PathBuf {
    recording.with_extension("model.toml")
}

/// Every file that the answers of a run come from: recordings, state, own model, and the model that judges a run without one.
pub fn files_of(recording: &Path, model: Option<PathBuf>) -> Vec<PathBuf> {
    let recordings = run_record::files_of(recording);
    let others = [run_record::path_of(recording), own_model(recording)];
    recordings.into_iter().chain(others).chain(model).collect()
}

/// Of every file that an answer comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Stamps(Vec<(PathBuf, Stamp)>);

impl Stamps {
    /// As they are now.
    pub fn of(files: impl IntoIterator<Item = PathBuf>) -> Self {
        let stamped = files.into_iter().map(|file| {
            let stamp = stamp(&file);
            (file, stamp)
        });
        Self(stamped.collect())
    }
}
