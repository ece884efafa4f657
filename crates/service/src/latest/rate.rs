//! How many readings arrive in a second.

use std::time::Duration;
use trunnion_core::HostTime;

/// Long enough for polled devices of one reading a second, short against a cycle.
const WINDOW: Duration = Duration::from_secs(10);

/// Readings of all devices, counted in windows.
#[derive(Default)]
pub(super) struct Rate {
    began: Option<HostTime>,
    count: u64,
    newest: HostTime,
    last_per_s: Option<f64>,
}

impl Rate {
    /// A reading arrived.
    pub(super) fn take(&mut self, at: HostTime) {
        let began = *self.began.get_or_insert(at);
        self.count += 1;
        self.newest = self.newest.max(at);
        if at - began >= WINDOW {
            self.last_per_s = Some(self.so_far());
            (self.began, self.count) = (Some(at), 0);
        }
    }

    /// In the last whole window; in the first, what came so far.
    pub(super) fn per_s(&self) -> f64 {
        self.last_per_s.unwrap_or_else(|| self.so_far())
    }

    fn so_far(&self) -> f64 {
        let Some(began) = self.began else { return 0.0 };
        // The first moments hold lumps.
        self.count as f64 / (self.newest - began).as_secs_f64().max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_whole_window_counts() {
        let mut rate = Rate::default();
        assert_eq!(rate.per_s(), 0.0);
        // 100 a second for 15 s, then 200 for 15 s.
        for k in 0..1500 {
            rate.take(HostTime(k * 10_000_000));
        }
        assert!((rate.per_s() - 100.0).abs() < 1.0, "{}", rate.per_s());
        for k in 0..3000 {
            rate.take(HostTime(15_000_000_000 + k * 5_000_000));
        }
        assert!((rate.per_s() - 200.0).abs() < 60.0, "{}", rate.per_s());
    }
}
