//! The system's clocks behind the `Clock` trait: the only place of the service that asks them; dates as texts.

use std::time::{Instant, SystemTime, UNIX_EPOCH};
use trunnion_core::{Clock, HostTime};
use trunnion_protocol::mtconnect::timestamp;

/// The host's monotonic clock, counted from when this was made.
#[derive(Clone, Copy, Debug)]
pub struct SystemClock {
    origin: Instant,
}

impl SystemClock {
    /// Starts counting.
    pub fn start() -> Self {
        Self { origin: Instant::now() }
    }
}

impl Clock for SystemClock {
    fn now(&self) -> HostTime {
        HostTime(i64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(i64::MAX))
    }

    fn wall_ns(&self) -> i64 {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        i64::try_from(since_1970.as_nanos()).unwrap_or(i64::MAX)
    }
}

/// `YYYYMMDDThhmmssZ`.
pub fn file_stamp(wall_ns: i64) -> String {
    timestamp(wall_ns).strftime("%Y%m%dT%H%M%SZ").to_string()
}

/// `YYYY-MM-DD`.
pub fn day(wall_ns: i64) -> String {
    timestamp(wall_ns).strftime("%Y-%m-%d").to_string()
}

/// `YYYY-MM-DD hh:mm UTC`, as runs are dated; the day alone where the clock is not set.
pub fn minute(wall_ns: i64) -> String {
    trunnion::moment::minute(wall_ns).unwrap_or_else(|| day(wall_ns))
}

/// `YYYY-MM-DDThh:mm:ssZ`.
pub fn moment(wall_ns: i64) -> String {
    timestamp(wall_ns).strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}
