//! The files that the answers of a run come from, and whether they are those that were read.

use crate::run_record;
use crate::stamp::{Stamp, stamp};
use std::path::{Path, PathBuf};

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
