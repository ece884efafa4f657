//! Where a file is damaged.

use std::fmt;

/// What of a recording cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Byte at which the first damage was found.
    pub offset: u64,
    /// What is wrong there.
    pub reason: String,
    /// What is missing because of it.
    pub lost: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "damaged at byte {}: {}; lost: {}", self.offset, self.reason, self.lost)
    }
}
