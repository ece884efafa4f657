//! What end-to-end tests share: paths of the workspace and its outside data.

use std::path::PathBuf;

/// Root folder of the workspace.
pub fn workspace_root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
