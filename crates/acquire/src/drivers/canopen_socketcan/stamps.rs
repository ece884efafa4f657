//! Kernel stamps are on CLOCK_REALTIME, which people and NTP set; the program counts on the monotonic clock.
//! host = stamp − (wall − monotonic), the difference sampled when the frame is read.
//!
//! Valid while the wall clock is not set between stamp and reading (some ms). When it is, the stamps of that moment are
//! wrong by the step: what comes out is therefore never later than the reading nor earlier than the frame before.

use trunnion_core::{Clock, HostTime};

/// The difference of the clocks is sampled again when the two readings around it are farther apart, ns.
const GOOD_SAMPLE_NS: i64 = 5_000;
const MOST_SAMPLES: usize = 3;
/// Changes of the difference beyond this are steps, ns: NTP slews by 0.5 ms/s at most, and frames come more often.
const STEP_NS: i64 = 10_000_000;

/// How much two samples of the difference may differ, ns: a processor that does something else between two clocks.
const SLACK_NS: i64 = 1_000_000;

/// Converts stamps in the order of their frames.
#[derive(Debug, Default)]
pub(super) struct Stamps {
    wall_minus_host_ns: Option<i64>,
    last: Option<HostTime>,
}

/// A converted stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stamped {
    /// The moment on the host's monotonic clock.
    pub at: HostTime,
    /// False when the stamp cannot be right: earlier than that of the frame before, or later than now.
    pub trusted: bool,
    /// The wall clock was set since the frame before, by so much, ns.
    pub step_ns: Option<i64>,
}

impl Stamps {
    /// `stamp_ns` since 1970 UTC, of a frame just read.
    pub(super) fn convert(&mut self, stamp_ns: i64, clock: &dyn Clock) -> Stamped {
        let (wall_minus_host_ns, now) = difference(clock);
        let before = self.wall_minus_host_ns.replace(wall_minus_host_ns);
        let step_ns = before.map(|before| wall_minus_host_ns - before).filter(|step| step.abs() > STEP_NS);
        let converted = HostTime(stamp_ns.saturating_sub(wall_minus_host_ns));
        let at = converted.max(self.last.unwrap_or(converted)).min(now);
        self.last = Some(at);
        let trusted = at == converted || (at.0 - converted.0).abs() < SLACK_NS;
        Stamped { at, trusted, step_ns }
    }
}

/// Wall clock minus monotonic clock, ns, and the monotonic clock after sampling.
fn difference(clock: &dyn Clock) -> (i64, HostTime) {
    let sample = || {
        let (before, wall_ns, after) = (clock.now(), clock.wall_ns(), clock.now());
        (after.0 - before.0, wall_ns - (before.0 + after.0) / 2, after)
    };
    let mut best = sample();
    for _ in 1..MOST_SAMPLES {
        if best.0 <= GOOD_SAMPLE_NS {
            break;
        }
        let (span_ns, difference_ns, after) = sample();
        if span_ns < best.0 {
            (best.0, best.1) = (span_ns, difference_ns);
        }
        best.2 = after;
    }
    (best.1, best.2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicI64, Ordering};

    struct Fixed {
        now_ns: AtomicI64,
        wall_minus_host_ns: AtomicI64,
    }

    impl Clock for Fixed {
        fn now(&self) -> HostTime {
            HostTime(self.now_ns.load(Ordering::Relaxed))
        }

        fn wall_ns(&self) -> i64 {
            self.now_ns.load(Ordering::Relaxed) + self.wall_minus_host_ns.load(Ordering::Relaxed)
        }
    }

    const MS: i64 = 1_000_000;
    const HOUR: i64 = 3_600_000 * MS;

    #[test]
    fn a_wall_clock_that_is_set_moves_no_frame_and_is_reported() {
        let clock = Fixed { now_ns: AtomicI64::new(0), wall_minus_host_ns: AtomicI64::new(400_000 * HOUR) };
        let mut stamps = Stamps::default();
        let mut read = |now_ns: i64, set_ns: i64, stamp_ns: i64| {
            clock.now_ns.store(now_ns, Ordering::Relaxed);
            clock.wall_minus_host_ns.fetch_add(set_ns, Ordering::Relaxed);
            let found = stamps.convert(stamp_ns + 400_000 * HOUR, &clock);
            assert_eq!(found.trusted, found.step_ns.is_none());
            (found.at.0, found.step_ns)
        };
        assert_eq!(read(10 * MS, 0, 9 * MS), (9 * MS, None));
        // Stamped before the clock was set back by an hour, read after it: not later than now.
        assert_eq!(read(20 * MS, -HOUR, 19 * MS), (20 * MS, Some(-HOUR)));
        assert_eq!(read(31 * MS, 0, 30 * MS - HOUR), (30 * MS, None));
        // Set forward again: not before the frame before.
        assert_eq!(read(41 * MS, HOUR, 40 * MS - HOUR), (30 * MS, Some(HOUR)));
        assert_eq!(read(51 * MS, 0, 50 * MS), (50 * MS, None));
        // Slewing by 0.5 ms/s is no step.
        assert_eq!(read(61 * MS, 5_000, 60 * MS + 5_000), (60 * MS, None));
    }
}
