//! What end-to-end tests share: paths of the workspace and its outside data.

pub mod alignment;
pub mod section;

use std::path::PathBuf;

/// Root folder of the workspace.
pub fn workspace_root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Python with the packages of `tests/peers/requirements.txt`.
///
/// # Panics
/// When `tests/peers/run` has not set it up: a peer test never passes without its peer.
pub fn peers_python() -> PathBuf {
    std::env::var_os("TRUNNION_PEERS_PYTHON").expect("run the peer tests through tests/peers/run").into()
}
