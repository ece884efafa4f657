//! When a device measured, on the clock of this computer: its own clock, moved by the shortest delay of late.
//!
//! moment = device time + min(arrival − device time)  over the last one to two [`WINDOW`]s.
//! Arrivals are late after a pause of the program, never early; what is read at once shares its arrival.

use std::time::Duration;
use trunnion_core::HostTime;

/// Clocks of quartz are specified to ±50 ppm, so two of them part by at most 1 ms in this time: one value of the usual rate.
const WINDOW: Duration = Duration::from_secs(10);

/// Of one device, from its start to its reset.
#[derive(Default)]
pub struct Moments(Option<Delays>);

/// Shortest delays, ns.
struct Delays {
    begun: HostTime,
    /// Since then.
    now: i64,
    /// In the window before.
    before: i64,
}

impl Moments {
    /// What arrived then was measured at this time of the device, s.
    pub fn arrived(&mut self, device_s: f64, arrival: HostTime) {
        let delay = arrival.0 - ns(device_s);
        let delays = self.0.get_or_insert(Delays { begun: arrival, now: delay, before: delay });
        if arrival - delays.begun >= WINDOW {
            *delays = Delays { begun: arrival, now: delay, before: delays.now };
        }
        delays.now = delays.now.min(delay);
    }

    /// When it was measured; `None` before the first arrival.
    pub fn of(&self, device_s: f64) -> Option<HostTime> {
        self.0.as_ref().map(|delays| HostTime(ns(device_s) + delays.now.min(delays.before)))
    }
}

fn ns(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    #[test]
    fn a_clock_that_drifts_is_followed_and_a_late_arrival_is_not() {
        let mut moments = Moments::default();
        for ms in 0..60_000_i64 {
            // 100 ppm slow, and 40 ms late once a second
            let late_ms = if ms % 1000 == 0 { 40 } else { 0 };
            moments.arrived(ms as f64 * 1e-3 * (1.0 - 1e-4), HostTime((ms + late_ms) * MS));
        }
        let found = moments.of(60.0 * (1.0 - 1e-4)).unwrap();
        let off_ms = (found.0 - 60_000 * MS) as f64 / MS as f64;
        assert!((-2.0..=0.0).contains(&off_ms), "{off_ms} ms");
    }
}
