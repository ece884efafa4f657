//! Time stamps. The host's monotonic clock is the reference; the wall clock only labels.

use std::ops::{Add, Sub};
use std::time::Duration;

/// A moment on the host's monotonic clock, ns since an arbitrary origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct HostTime(pub i64);

impl HostTime {
    /// Seconds from `origin` to this moment.
    pub fn seconds_since(self, origin: Self) -> f64 {
        (self.0 - origin.0) as f64 * 1e-9
    }
}

impl Add<Duration> for HostTime {
    type Output = Self;
    fn add(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)))
    }
}

impl Sub<Duration> for HostTime {
    type Output = Self;
    fn sub(self, duration: Duration) -> Self {
        Self(self.0.saturating_sub(i64::try_from(duration.as_nanos()).unwrap_or(i64::MAX)))
    }
}

impl Sub for HostTime {
    type Output = Duration;
    /// Zero when `earlier` is later.
    fn sub(self, earlier: Self) -> Duration {
        Duration::from_nanos(u64::try_from(self.0 - earlier.0).unwrap_or(0))
    }
}

/// Where the present comes from. Libraries take it as an argument and never ask the system.
pub trait Clock: Send + Sync {
    /// The present moment on the host's monotonic clock.
    fn now(&self) -> HostTime;
    /// The wall clock, ns since 1970 UTC; for labels only.
    fn wall_ns(&self) -> i64;
}
