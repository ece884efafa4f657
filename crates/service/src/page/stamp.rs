//! Whether a file is the one that was read.

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

/// Of a recording and its own model.
pub fn stamps(recording: &Path) -> [Stamp; 2] {
    [stamp(recording), stamp(&own_model(recording))]
}
