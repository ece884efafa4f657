//! The wall clock as removal by age takes it: one that is set forward ages nothing.

use std::sync::Arc;
use std::time::{Duration, SystemTime};
use trunnion_core::{Clock, HostTime};

/// What the clocks say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Today {
    /// The wall clock.
    pub wall: SystemTime,
    /// How far it was set forward since the service began; time in which the computer slept looks the same.
    pub set_forward: Duration,
}

impl Today {
    /// The wall clock as if nobody had set it forward.
    pub(super) fn proven(self) -> SystemTime {
        self.wall.checked_sub(self.set_forward).unwrap_or(SystemTime::UNIX_EPOCH)
    }

    /// Of a clock that nobody set.
    #[cfg(test)]
    pub(super) fn of(wall: SystemTime) -> Self {
        Self { wall, set_forward: Duration::ZERO }
    }
}

/// The wall clock since the service began, against the monotonic one.
#[derive(Clone)]
pub struct WallClock {
    clock: Arc<dyn Clock>,
    began: (i64, HostTime),
}

impl WallClock {
    /// A clock that moves by more than this against the monotonic one was set: a leap second, a thread that waits for a processor,
    /// and what NTP corrects without a step are less. The shortest `keep_days` is fourteen minutes.
    pub const SET: Duration = Duration::from_secs(60);

    /// From now on.
    pub fn start(clock: Arc<dyn Clock>) -> Self {
        let began = (clock.wall_ns(), clock.now());
        Self { clock, began }
    }

    /// What the clocks say now.
    pub fn today(&self) -> Today {
        let wall = u64::try_from(self.clock.wall_ns()).unwrap_or(0);
        let set_forward = u64::try_from(self.set_ns()).unwrap_or(0);
        let wall = SystemTime::UNIX_EPOCH + Duration::from_nanos(wall);
        Today { wall, set_forward: Duration::from_nanos(set_forward) }
    }

    /// How far the clock was set since the service began, s; zero where it was not.
    pub fn set_s(&self) -> f64 {
        let ns = self.set_ns();
        if u128::from(ns.unsigned_abs()) > Self::SET.as_nanos() { ns as f64 * 1e-9 } else { 0.0 }
    }

    fn set_ns(&self) -> i64 {
        let (wall_ns, at) = self.began;
        let ran = self.clock.now().0.saturating_sub(at.0);
        self.clock.wall_ns().saturating_sub(wall_ns).saturating_sub(ran)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicI64, Ordering};

    /// Both clocks, ns.
    #[derive(Default)]
    struct Set {
        now: AtomicI64,
        wall: AtomicI64,
    }

    impl Clock for Set {
        fn now(&self) -> HostTime {
            HostTime(self.now.load(Ordering::Relaxed))
        }
        fn wall_ns(&self) -> i64 {
            self.wall.load(Ordering::Relaxed)
        }
    }

    #[test]
    fn a_clock_that_is_set_is_noticed_and_time_that_passes_is_not() {
        const S: i64 = 1_000_000_000;
        let set = Arc::new(Set::default());
        let (hour, year) = (3600 * S, 365 * 24 * 3600 * S);
        set.wall.store(50 * year, Ordering::Relaxed);
        let clock = WallClock::start(set.clone());
        let pass = |now: i64, wall: i64| {
            set.now.fetch_add(now, Ordering::Relaxed);
            set.wall.fetch_add(wall, Ordering::Relaxed);
            (clock.set_s().round(), clock.today().set_forward.as_secs())
        };
        assert_eq!(pass(hour, hour + S), (0.0, 1), "a leap second");
        assert_eq!(pass(hour, hour + 10 * year), (10.0 * 365.0 * 86_400.0 + 1.0, 315_360_001));
        let proven = clock.today().proven().duration_since(SystemTime::UNIX_EPOCH).unwrap();
        assert_eq!(proven.as_nanos(), (50 * year + 2 * hour) as u128);
        assert_eq!(pass(hour, hour - 10 * year), (0.0, 1), "as it was");
        assert_eq!(pass(hour, hour - year), (1.0 - 365.0 * 86_400.0, 0), "set back");
    }
}
