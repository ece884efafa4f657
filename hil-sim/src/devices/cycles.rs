//! The moments at which a controller samples its axes: cycles of its own clock, counted from its 0.

use super::clock::DeviceClock;
use std::ops::Range;

/// Cycles that lie further back are not made up for, s.
const BACKLOG_S: f64 = 1.0;

#[derive(Debug, Clone)]
pub(super) struct Cycles {
    clock: DeviceClock,
    rate_hz: f64,
    next: u64,
}

impl Cycles {
    /// The first is the next after `now_s`.
    pub fn new(clock: DeviceClock, rate_hz: f64, now_s: f64) -> Self {
        let mut cycles = Self { clock, rate_hz, next: 0 };
        cycles.next = cycles.after(now_s);
        cycles
    }

    /// When the next one is due, time of the cell, s.
    pub fn due_s(&self) -> f64 {
        self.at_s(self.next as f64)
    }

    /// The one before it.
    #[cfg(feature = "opcua")]
    pub fn last(&self) -> u64 {
        self.next.saturating_sub(1)
    }

    /// Those up to now.
    pub fn take(&mut self, now_s: f64) -> Range<u64> {
        let first = self.next.max(self.after(now_s - BACKLOG_S));
        self.next = self.after(now_s).max(first + u64::from(self.at_s(first as f64) <= now_s));
        first..self.next
    }

    /// When so many cycles have passed, time of the cell, s.
    pub fn at_s(&self, cycles: f64) -> f64 {
        self.clock.cell_s(self.clock.offset_s + cycles / self.rate_hz)
    }

    /// The first cycle after `t_s`.
    fn after(&self, t_s: f64) -> u64 {
        let shown_s = self.clock.device_s(t_s) - self.clock.offset_s;
        ((shown_s * self.rate_hz).floor() + 1.0).max(0.0) as u64
    }
}
