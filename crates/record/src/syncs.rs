//! When what was written goes to the disk: often enough that a power cut costs a tenth of a second, and no oftener than the disk bears.
//!
//! `fdatasync` takes 0.1 to 37 ms on the disks that were tried (docs/design/numerics.md §2). It is called on the thread of the recorder,
//! so that nothing that reads a device waits for it; what arrives meanwhile waits in the queue.

use std::time::Duration;
use trunnion_core::HostTime;

/// From the beginning of one sync to that of the next, where the disk is quick: as long as a batch waits, so that it is written once.
pub const PERIOD: Duration = Duration::from_millis(40);
/// A slow disk is left alone for this part of the time that its last sync took. Writing what came meanwhile takes some hundredths of
/// it: the recorder takes 2.6 million readings a second of a processor (docs/design/numerics.md §2), and 12 000 a second come.
const REST: f64 = 0.25;
/// What a power cut may cost.
pub const AT_RISK: Duration = Duration::from_millis(100);

/// The syncs of a run so far.
pub struct Syncs {
    /// When the last one that succeeded began: what was accepted before is on the disk.
    safe: HostTime,
    due: HostTime,
    at_risk: Duration,
    is_slow: bool,
    was_refused: bool,
}

impl Syncs {
    /// Of a journal that begins now.
    pub fn begin(now: HostTime) -> Self {
        Self { safe: now, due: now + PERIOD, at_risk: Duration::ZERO, is_slow: false, was_refused: false }
    }

    /// True when it is time.
    pub fn is_due(&self, now: HostTime) -> bool {
        now >= self.due
    }

    /// One is over; all that was accepted before it is on the disk, or it is not. A slow disk is logged.
    pub fn done(&mut self, began: HostTime, ended: HostTime, is_on_disk: bool) {
        let took = ended - began;
        self.due = (began + PERIOD).max(ended + took.mul_f64(REST));
        let at_risk = ended - self.safe;
        self.at_risk = self.at_risk.max(at_risk);
        if is_on_disk {
            self.safe = began;
        }
        // What a disk refuses is logged as such, and is no sign of a slow one.
        let was_refused = std::mem::replace(&mut self.was_refused, !is_on_disk);
        let is_slow = at_risk > AT_RISK && is_on_disk && !was_refused;
        // Once a run: a disk that is slow now and then would fill the log.
        if is_slow && !std::mem::replace(&mut self.is_slow, true) {
            tracing::warn!(
                "the disk is slow: a power cut would have cost the last {:.2} s, not {:.1} s; keeping what was recorded took {:.0} ms",
                at_risk.as_secs_f64(),
                AT_RISK.as_secs_f64(),
                took.as_secs_f64() * 1e3,
            );
        }
    }

    /// Longest time for which samples were accepted and not on the disk.
    pub fn at_risk(&self) -> Duration {
        self.at_risk
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: i64) -> HostTime {
        HostTime(ms * 1_000_000)
    }

    #[test]
    fn a_quick_disk_is_synced_every_period_and_a_slow_one_has_a_rest() {
        let mut syncs = Syncs::begin(ms(0));
        assert!(!syncs.is_due(ms(39)) && syncs.is_due(ms(40)));
        syncs.done(ms(40), ms(41), true);
        assert!(!syncs.is_due(ms(79)) && syncs.is_due(ms(80)));
        assert_eq!(syncs.at_risk(), Duration::from_millis(41));
        // Slower than any that was tried: 400 ms, then 100 ms of rest.
        syncs.done(ms(80), ms(480), true);
        assert!(!syncs.is_due(ms(579)) && syncs.is_due(ms(580)));
        assert_eq!(syncs.at_risk(), Duration::from_millis(440));
    }

    #[test]
    fn what_a_disk_refuses_stays_at_risk() {
        let mut syncs = Syncs::begin(ms(0));
        syncs.done(ms(40), ms(41), false);
        syncs.done(ms(80), ms(81), false);
        syncs.done(ms(120), ms(121), true);
        assert_eq!(syncs.at_risk(), Duration::from_millis(121));
        syncs.done(ms(160), ms(161), true);
        assert_eq!(syncs.at_risk(), Duration::from_millis(121));
    }
}
