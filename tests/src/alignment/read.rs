//! The drivers at work on a clock that shows the simulator's time.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};
use tokio_util::sync::CancellationToken;
use trunnion_acquire::supervisor::QUEUE_LENGTH;
use trunnion_acquire::{DeviceConfig, start};
use trunnion_core::reading::Message;
use trunnion_core::{Clock, HostTime};
use trunnion_hil_sim::devices::TimeOrigin;

/// The simulator's time as the host's clock; the wall clock is that of this computer.
struct CellClock(TimeOrigin);

impl Clock for CellClock {
    fn now(&self) -> HostTime {
        HostTime((self.0.now_s() * 1e9).round() as i64)
    }

    fn wall_ns(&self) -> i64 {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
    }
}

/// Reads the devices until `seconds` after time 0 of the simulator; their messages.
pub async fn read(devices: Vec<DeviceConfig>, origin: TimeOrigin, seconds: f64) -> Vec<Message> {
    let clock = Arc::new(CellClock(origin));
    let mut acquisition = start(devices, clock, CancellationToken::new(), QUEUE_LENGTH);
    let mut messages = Vec::new();
    let end = origin.instant_of(seconds);
    while let Ok(message) = tokio::time::timeout_at(end, acquisition.messages.recv()).await {
        messages.extend(message);
    }
    messages.extend(acquisition.stop().await);
    messages
}
