//! Between which moments the values lie that a server could not keep. It says so with the next value of the item
//! (OPC UA part 4, StatusCode bit Overflow); items report changes only, so that the last value of one may be hours old.

use crate::moments::Moments;
use trunnion_core::HostTime;

/// What is known of when.
pub(super) struct Missing {
    /// Of the axes alone: a server may stamp its other items by another clock.
    moments: Moments,
    /// Last stamp of each item, ns.
    stamps: Vec<Option<i64>>,
    /// No axis misses a value of before.
    complete: HostTime,
    /// Newest moment of the notification that is being taken.
    newest: HostTime,
}

/// One value of an item.
pub(super) struct Stamped {
    pub(super) item: usize,
    /// Of an axis; none for what another clock may have stamped.
    pub(super) stamp_ns: Option<i64>,
    /// The clock of the axes was set back before it.
    pub(super) set_back: bool,
    /// Others of before could not be kept.
    pub(super) overflow: bool,
    pub(super) arrival: HostTime,
}

impl Missing {
    pub(super) fn new(items: usize, now: HostTime) -> Self {
        Self { moments: Moments::default(), stamps: vec![None; items], complete: now, newest: now }
    }

    /// The gap before this value: after the last one of its item, and after the notification of before, which had all that was kept.
    pub(super) fn take(&mut self, value: &Stamped) -> Option<(HostTime, HostTime)> {
        if value.set_back {
            self.moments = Moments::default();
            self.stamps.fill(None);
        }
        let last_ns = self.stamps[value.item];
        if let Some(stamp_ns) = value.stamp_ns {
            self.moments.arrived(stamp_ns as f64 * 1e-9, value.arrival);
            self.stamps[value.item] = Some(stamp_ns);
        }
        let moment = |stamp_ns: Option<i64>| self.moments.of(stamp_ns? as f64 * 1e-9);
        let measured = moment(value.stamp_ns);
        self.newest = self.newest.max(measured.unwrap_or(self.newest));
        let gap = || {
            let from =
                moment(last_ns).map_or(self.complete, |last| last.max(self.complete)).min(value.arrival);
            (from, measured.unwrap_or(value.arrival).max(from))
        };
        value.overflow.then(gap)
    }

    /// The notification was taken.
    pub(super) fn notified(&mut self) {
        self.complete = self.complete.max(self.newest);
    }

    /// The server is up, and all axes stood until then.
    pub(super) fn stood_until(&mut self, moment: HostTime) {
        self.complete = self.complete.max(moment);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;
    /// The clock of the controller, ahead of ours.
    const AHEAD_MS: i64 = 3_600_000;

    /// Two axes and the state of the program, of which times are in ms.
    struct Bench(Missing);

    impl Bench {
        fn takes(
            &mut self,
            item: usize,
            stamp_ms: i64,
            arrival_ms: i64,
            overflow: bool,
        ) -> Option<(i64, i64)> {
            let stamp_ns = (item < 2).then_some((stamp_ms + AHEAD_MS) * MS);
            let arrival = HostTime(arrival_ms * MS);
            let found = self.0.take(&Stamped { item, stamp_ns, set_back: false, overflow, arrival });
            self.0.notified();
            found.map(|(from, to)| (from.0 / MS, to.0 / MS))
        }
    }

    fn bench() -> Bench {
        let mut bench = Bench(Missing::new(3, HostTime(0)));
        for item in [0, 1] {
            assert_eq!(bench.takes(item, 100, 105, false), None);
        }
        bench
    }

    #[test]
    fn values_that_were_not_kept_are_missing_since_the_axes_were_last_known_and_not_since_this_one_moved() {
        // C stands for half an hour while X moves: its last notification was complete.
        let mut bench = bench();
        for ms in (200..1_800_000).step_by(100) {
            bench.takes(0, ms, ms + 5, false);
        }
        assert_eq!(bench.takes(1, 1_803_000, 1_803_400, true), Some((1_799_905, 1_803_005)));
        bench.takes(0, 1_803_500, 1_803_505, false);
        // Both stand, and the server answers all the while.
        bench.0.stood_until(HostTime(3_600_000 * MS));
        assert_eq!(bench.takes(1, 3_604_000, 3_604_900, true), Some((3_600_000, 3_604_005)));
        // The notification of before came late: what was lost after it was published is missing too.
        bench.takes(1, 3_605_000, 3_612_000, false);
        assert_eq!(bench.takes(1, 3_611_000, 3_612_001, true), Some((3_605_005, 3_611_005)));
    }

    #[test]
    fn neither_another_clock_nor_one_that_is_set_back_moves_a_gap() {
        let mut bench = bench();
        // What the server stamps itself is known by its arrival.
        assert_eq!(bench.takes(2, 5_000, 400, true), Some((105, 400)));
        assert_eq!(bench.takes(0, 500, 505, true), Some((105, 505)));
        // One hour back.
        let (stamp_ns, arrival) = (Some(1_000 * MS), HostTime(1_005 * MS));
        let value = Stamped { item: 0, stamp_ns, set_back: true, overflow: true, arrival };
        assert_eq!(bench.0.take(&value), Some((HostTime(505 * MS), arrival)));
    }
}
