//! The controller's wall clock.

use crate::devices::clock::{DeviceClock, TimeOrigin};

/// The controller's wall clock, for the agent's headers.
pub(super) struct WallClock {
    pub origin: TimeOrigin,
    pub ns_at_origin: i64,
    pub clock: DeviceClock,
}

impl WallClock {
    pub(super) fn now_ns(&self) -> i64 {
        self.ns_at_origin + (self.clock.device_s(self.origin.now_s()) * 1e9).round() as i64
    }
}
