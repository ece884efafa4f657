//! Time on the shop floor and in the devices.
//! x = x₀ + (1 + ε) t + A sin(2π t/P): x device time, t time of the cell, ε rate error, A and P slow wander.

use std::f64::consts::TAU;
use std::time::Duration;
use tokio::time::Instant;

/// The instant that is time 0 of a cell; shared by all its devices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimeOrigin(pub Instant);

impl TimeOrigin {
    /// Seconds from time 0 to `instant`, negative before it.
    pub fn seconds_at(self, instant: Instant) -> f64 {
        match instant.checked_duration_since(self.0) {
            Some(after) => after.as_secs_f64(),
            None => -self.0.duration_since(instant).as_secs_f64(),
        }
    }

    /// Time of the cell now, s. The devices are the one part of the simulator that lives in real time.
    pub fn now_s(self) -> f64 {
        self.seconds_at(Instant::now())
    }

    /// The instant of a time of the cell; times before 0 give the origin.
    pub fn instant_of(self, t_s: f64) -> Instant {
        self.0 + Duration::try_from_secs_f64(t_s.max(0.0)).unwrap_or(Duration::from_secs(86_400 * 365))
    }
}

/// The clock inside a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviceClock {
    /// What it shows at time 0 of the cell, s.
    pub offset_s: f64,
    /// Rate error, parts per million; +30 gains 30 µs every second.
    pub rate_ppm: f64,
    /// Amplitude of a slow wander, µs.
    pub wander_us: f64,
    /// Period of the wander, s; not used while the amplitude is 0.
    pub wander_period_s: f64,
}

impl DeviceClock {
    /// A clock that starts at `offset_s` and is off by a constant rate.
    pub fn steady(offset_s: f64, rate_ppm: f64) -> Self {
        Self { offset_s, rate_ppm, wander_us: 0.0, wander_period_s: 1.0 }
    }

    /// What the clock shows at time `t_s` of the cell, s.
    pub fn device_s(&self, t_s: f64) -> f64 {
        self.offset_s + t_s + self.error_s(t_s)
    }

    /// When the clock shows `device_s`, in time of the cell, s.
    pub fn cell_s(&self, device_s: f64) -> f64 {
        let shown_s = device_s - self.offset_s;
        // Fixed point t = shown − error(t): the error changes by less than a thousandth of t, so each round gains
        // three digits or more.
        (0..5).fold(shown_s, |t_s, _| shown_s - self.error_s(t_s))
    }

    fn error_s(&self, t_s: f64) -> f64 {
        let wander_s = if self.wander_us == 0.0 {
            0.0
        } else {
            1e-6 * self.wander_us * (TAU * t_s / self.wander_period_s).sin()
        };
        1e-6 * self.rate_ppm * t_s + wander_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_time_goes_to_cell_time_and_back() {
        let clock =
            DeviceClock { offset_s: 1234.5, rate_ppm: -80.0, wander_us: 300.0, wander_period_s: 60.0 };
        for t_s in [0.0, 1e-3, 17.3, 3600.0] {
            assert!((clock.cell_s(clock.device_s(t_s)) - t_s).abs() < 1e-11);
        }
        assert!((DeviceClock::steady(5.0, 30.0).device_s(100.0) - 105.003).abs() < 1e-12);
    }
}
