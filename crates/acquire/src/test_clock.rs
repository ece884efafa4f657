//! A clock that stands still.

use trunnion_core::{Clock, HostTime};

/// Always zero: what happens when is in the arrivals that a test gives.
pub struct AtZero;

impl Clock for AtZero {
    fn now(&self) -> HostTime {
        HostTime(0)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}
