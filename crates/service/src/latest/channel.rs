//! The latest values of one channel, and whether its number changes at all.

use trunnion_core::HostTime;
use trunnion_core::reading::ProbeReading;

/// A number must stay so long and for so many readings before it is called kept, s: as long as the stuck detector of the
/// driver waits for a channel that trembled before.
const KEPT_S: f64 = 2.0;
const KEPT_READINGS: u32 = 20;
/// Whether a channel trembles is judged from so many readings.
const WINDOW: u32 = 50;

/// What came of a channel.
#[derive(Debug, Default)]
pub(super) struct ChannelValues {
    latest: Option<ProbeReading>,
    /// The number of the latest readings: since when, how many.
    kept: Option<(HostTime, u32)>,
    /// Readings of the window under way, and those whose number differed from the one before.
    window: (u32, u32),
    /// The number changed at half of the readings of the window before, as noise does.
    trembles: bool,
}

impl ChannelValues {
    pub(super) fn take(&mut self, reading: &ProbeReading) {
        let changed = self.latest.is_none_or(|latest| latest.raw != reading.raw);
        self.kept = match self.kept {
            Some((since, readings)) if !changed => Some((since, readings.saturating_add(1))),
            _ => Some((reading.arrival, 1)),
        };
        self.latest = Some(*reading);
        let (readings, changes) = self.window;
        self.window = (readings + 1, changes + u32::from(changed));
        if self.window.0 == WINDOW {
            self.trembles = 2 * self.window.1 >= WINDOW;
            self.window = (0, 0);
        }
    }

    /// The latest value that is not older than `limit_s`.
    pub(super) fn value_mm(&self, now: HostTime, limit_s: f64) -> Option<f64> {
        let latest = self.latest.filter(|latest| now.seconds_since(latest.arrival) <= limit_s)?;
        Some(latest.value_mm).filter(|value_mm| value_mm.is_finite())
    }

    /// For how long the number has been one and the same, s; `None` while that is too short to mean anything.
    pub(super) fn kept_s(&self, now: HostTime) -> Option<f64> {
        let (since, readings) = self.kept?;
        let kept_s = now.seconds_since(since);
        (kept_s >= KEPT_S && readings >= KEPT_READINGS).then_some(kept_s)
    }

    /// Whether the number changes as noise does.
    pub(super) fn trembles(&self) -> bool {
        self.trembles
    }
}
