//! Whether a file is the one that was read.

use std::path::Path;
use std::time::UNIX_EPOCH;

/// Changes when a file does: its length, and when it was written, ns since 1970. `None` where there is none. Stories keep it.
pub type Stamp = Option<(u64, u128)>;

/// Of a file as it is now.
pub fn stamp(file: &Path) -> Stamp {
    let about = file.metadata().ok()?;
    Some((about.len(), about.modified().ok()?.duration_since(UNIX_EPOCH).ok()?.as_nanos()))
}
