//! When the ball was mounted again: between the last pose of a setup and the first pose of the next nothing is asked of the devices. A
//! probe is out of its range then, and its cable may be pulled.
//!
//! The stretch goes from the middle of one reading to the middle of the other, which a recording holds too: where both were read, nothing
//! that is missing in between cost a pose.

use trunnion_core::{Gap, Point, Quality};

/// Stretches of one run in which the ball was mounted again.
#[derive(Clone, Debug, Default)]
pub struct Remounts {
    /// Setup of the last pose, and when it was read, s; `None` for one that was not read, which shows what the devices missed.
    last: Option<(usize, Option<f64>)>,
    /// From when to when, s.
    stretches: Vec<(f64, f64)>,
}

impl Remounts {
    /// The next pose that was decided.
    pub fn take(&mut self, point: &Point) {
        let setup = point.state.setup;
        let read_s = point.state.time_s.filter(|_| point.quality == Quality::Good);
        let left_s = self.last.filter(|(last, _)| *last != setup).and_then(|(_, left_s)| left_s);
        self.stretches.extend(left_s.zip(read_s));
        self.last = Some((setup, read_s));
    }

    /// True for a gap in which nothing was asked.
    pub fn hold(&self, gap: &Gap) -> bool {
        self.stretches.iter().any(|(from_s, to_s)| gap.from_s >= *from_s && gap.to_s <= *to_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion_core::State;

    fn point(setup: usize, time_s: f64, quality: Quality) -> Point {
        let state = State { setup, time_s: Some(time_s), ..State::default() };
        Point { state, reading_mm: [0.0; 3], spread_mm: [0.0; 3], samples: 10, quality }
    }

    fn gap(from_s: f64, to_s: f64) -> Gap {
        Gap { source: "probe-1".into(), from_s, to_s, lost_samples: Some(48), reason: "out of range".into() }
    }

    #[test]
    fn only_what_is_missing_between_two_setups_is_no_loss() {
        let mut remounts = Remounts::default();
        for (setup, time_s) in [(0, 1.0), (0, 2.0), (1, 9.0), (1, 10.0)] {
            remounts.take(&point(setup, time_s, Quality::Good));
        }
        assert!(remounts.hold(&gap(2.2, 8.5)));
        assert!(!remounts.hold(&gap(1.2, 1.8)), "between two poses of a setup");
        assert!(!remounts.hold(&gap(2.2, 9.5)), "into the first pose of the next");
        assert!(!remounts.hold(&gap(1.9, 8.5)), "from the last pose of the one before");
    }

    #[test]
    fn a_pose_that_was_not_read_excuses_nothing() {
        let excused = |last: Quality, first: Quality| {
            let mut remounts = Remounts::default();
            remounts.take(&point(0, 1.0, last));
            remounts.take(&point(1, 9.0, first));
            remounts.take(&point(1, 10.0, Quality::Good));
            remounts.hold(&gap(2.0, 8.0))
        };
        assert!(excused(Quality::Good, Quality::Good));
        assert!(!excused(Quality::Good, Quality::Unsettled), "the first of the next setup");
        assert!(!excused(Quality::Unsettled, Quality::Good), "the last of the setup");
    }
}
