//! Whether a file is the one that was read.

use std::path::Path;
use std::time::SystemTime;

/// Changes when a file does.
pub type Stamp = Option<(SystemTime, u64)>;

/// Of a file as it is now; `None` where there is none.
pub fn stamp(path: &Path) -> Stamp {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}
