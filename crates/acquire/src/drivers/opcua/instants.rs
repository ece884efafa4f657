//! Axes with a stamp each, brought to common instants.
//!
//! A server reports changes only, and each axis has its own stamp. An axis is known up to its newest sample; one that reported
//! nothing for longer than the hold time stands. Up to the moment until which all axes are known, every stamp is an
//! instant: the others are interpolated between their neighbouring samples. The skew of an instant is the farthest of
//! these neighbours, 0 where an axis stands.

use std::collections::VecDeque;

/// Samples kept of an axis; more are not needed for the hold time at any rate a server has.
const MAX_SAMPLES: usize = 1024;
/// Further back than any delay: the server's clock was set back, ns.
const SET_BACK_NS: i64 = 1_000_000_000;

/// All axes at one instant.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Instant {
    pub(super) stamp_ns: i64,
    /// In the order of the axes.
    pub(super) positions: Vec<f64>,
    pub(super) skew_ns: i64,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    stamp_ns: i64,
    position: f64,
    /// Not reported by the server: the axis stood.
    is_stand: bool,
}

/// Collects samples, gives instants.
#[derive(Debug)]
pub(super) struct Instants {
    axes: Vec<VecDeque<Sample>>,
    hold_ns: i64,
    /// Stamps closer to the last instant than this belong to it.
    step_ns: i64,
    given_ns: i64,
    newest_ns: i64,
}

impl Instants {
    /// For so many axes, sampled at this interval; a silent axis stands after `hold_ns`.
    pub(super) fn new(axes: usize, interval_ns: i64, hold_ns: i64) -> Self {
        Self {
            axes: vec![VecDeque::new(); axes],
            hold_ns,
            step_ns: interval_ns / 2,
            given_ns: i64::MIN,
            newest_ns: i64::MIN,
        }
    }

    /// With this stamp the clock of the axes was set back.
    pub(super) fn is_set_back(&self, stamp_ns: i64) -> bool {
        self.newest_ns.saturating_sub(stamp_ns) > SET_BACK_NS
    }

    /// A value as the server reported it. One that is not later than the last of its axis is left out.
    pub(super) fn sample(&mut self, axis: usize, stamp_ns: i64, position: f64) {
        if self.is_set_back(stamp_ns) {
            self.forget();
            (self.given_ns, self.newest_ns) = (i64::MIN, i64::MIN);
        }
        let samples = &mut self.axes[axis];
        while samples.back().is_some_and(|last| last.is_stand && last.stamp_ns >= stamp_ns) {
            samples.pop_back();
        }
        if samples.back().is_some_and(|last| last.stamp_ns >= stamp_ns) {
            return;
        }
        if samples.len() == MAX_SAMPLES {
            samples.pop_front();
        }
        samples.push_back(Sample { stamp_ns, position, is_stand: false });
        self.newest_ns = self.newest_ns.max(stamp_ns);
    }

    /// The newest stamp of the server, once there is one.
    pub(super) fn newest_ns(&self) -> Option<i64> {
        (self.newest_ns > i64::MIN).then_some(self.newest_ns)
    }

    /// Nothing is known any more: a value is missing.
    pub(super) fn forget(&mut self) {
        self.axes.iter_mut().for_each(VecDeque::clear);
    }

    /// The instants that have become known.
    pub(super) fn take(&mut self) -> Vec<Instant> {
        self.stand_until(self.newest_ns.saturating_sub(self.hold_ns));
        self.give()
    }

    /// Nobody moves: all axes are where they are until `stamp_ns`. Gives what was waiting, and that instant.
    pub(super) fn all_stand(&mut self, stamp_ns: i64) -> Vec<Instant> {
        self.stand_until(self.newest_ns);
        let mut instants = self.give();
        self.stand_until(stamp_ns);
        instants.extend(self.at(stamp_ns).filter(|instant| instant.stamp_ns > self.given_ns));
        self.given_ns = self.given_ns.max(stamp_ns);
        self.drop_old();
        instants
    }

    fn stand_until(&mut self, stamp_ns: i64) {
        for samples in &mut self.axes {
            let Some(last) = samples.back_mut().filter(|last| last.stamp_ns < stamp_ns) else { continue };
            if last.is_stand {
                last.stamp_ns = stamp_ns;
            } else {
                let position = last.position;
                samples.push_back(Sample { stamp_ns, position, is_stand: true });
            }
        }
    }

    fn give(&mut self) -> Vec<Instant> {
        let Some(known_ns) = self.axes.iter().map(|s| s.back().map(|last| last.stamp_ns)).min().flatten()
        else {
            return Vec::new();
        };
        let later = |sample: &&Sample| sample.stamp_ns > self.given_ns && sample.stamp_ns <= known_ns;
        let mut stamps: Vec<i64> =
            self.axes.iter().flatten().filter(later).map(|sample| sample.stamp_ns).collect();
        stamps.sort_unstable();
        let mut instants = Vec::new();
        for stamp_ns in stamps {
            let near = self.given_ns > i64::MIN && stamp_ns - self.given_ns <= self.step_ns;
            if !near && let Some(instant) = self.at(stamp_ns) {
                self.given_ns = stamp_ns;
                instants.push(instant);
            }
        }
        self.drop_old();
        instants
    }

    /// `None` when an axis has no sample before or after.
    fn at(&self, stamp_ns: i64) -> Option<Instant> {
        let mut instant = Instant { stamp_ns, positions: Vec::with_capacity(self.axes.len()), skew_ns: 0 };
        for samples in &self.axes {
            let after = samples.iter().position(|sample| sample.stamp_ns >= stamp_ns)?;
            let next = samples[after];
            if next.stamp_ns == stamp_ns {
                instant.positions.push(next.position);
                continue;
            }
            let last = samples[after.checked_sub(1)?];
            let share = (stamp_ns - last.stamp_ns) as f64 / (next.stamp_ns - last.stamp_ns) as f64;
            instant.positions.push(last.position + share * (next.position - last.position));
            if next.position != last.position {
                let nearest = (stamp_ns - last.stamp_ns).min(next.stamp_ns - stamp_ns);
                instant.skew_ns = instant.skew_ns.max(nearest);
            }
        }
        Some(instant)
    }

    /// Of each axis, the last sample before the last instant is still needed.
    fn drop_old(&mut self) {
        for samples in &mut self.axes {
            while samples.get(1).is_some_and(|second| second.stamp_ns <= self.given_ns) {
                samples.pop_front();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn stamps(instants: &[Instant]) -> Vec<i64> {
        instants.iter().map(|instant| instant.stamp_ns / MS).collect()
    }

    #[test]
    fn axes_with_a_common_stamp_pass_unchanged_and_without_skew() {
        let mut instants = Instants::new(2, 10 * MS, 40 * MS);
        instants.sample(0, 10 * MS, 1.0);
        instants.sample(1, 10 * MS, 2.0);
        instants.sample(0, 20 * MS, 1.5);
        instants.sample(1, 20 * MS, 2.5);
        let given = instants.take();
        assert_eq!(stamps(&given), [10, 20]);
        assert_eq!((given[1].positions.clone(), given[1].skew_ns), (vec![1.5, 2.5], 0));
    }

    #[test]
    fn staggered_axes_are_interpolated_and_their_skew_is_reported() {
        let mut instants = Instants::new(2, 10 * MS, 40 * MS);
        // Axis 1 is sampled 3 ms after axis 0; both move at one unit a millisecond.
        let mut given = Vec::new();
        for k in 0..10 {
            instants.sample(0, 10 * k * MS, (10 * k) as f64);
            instants.sample(1, (10 * k + 3) * MS, (10 * k + 3) as f64);
            given.extend(instants.take());
        }
        assert_eq!(stamps(&given), [3, 10, 20, 30, 40, 50, 60, 70, 80, 90]);
        for instant in &given {
            let t = (instant.stamp_ns / MS) as f64;
            assert_eq!(instant.positions, [t, t]);
            assert_eq!(instant.skew_ns, 3 * MS);
        }
    }

    #[test]
    fn an_axis_that_reports_nothing_stands_and_begins_to_move_where_it_stood() {
        let mut instants = Instants::new(2, 10 * MS, 40 * MS);
        instants.sample(1, 0, 7.0);
        let mut given = Vec::new();
        for k in 0..=20 {
            instants.sample(0, 10 * k * MS, k as f64);
            given.extend(instants.take());
        }
        // The standing axis holds the others up by the hold time only.
        assert_eq!(stamps(&given).last(), Some(&160));
        assert!(given.iter().all(|instant| instant.positions[1] == 7.0 && instant.skew_ns == 0));
        instants.sample(1, 205 * MS, 8.0);
        instants.sample(0, 210 * MS, 21.0);
        let given = instants.take();
        // 205 is too near to 200 to be an instant of its own.
        assert_eq!(given.last().map(|i| i.stamp_ns / MS), Some(200));
        let at_180 = given.iter().find(|i| i.stamp_ns == 180 * MS).unwrap();
        assert!(at_180.positions[1] < 7.5 && at_180.positions[1] >= 7.0);
    }

    #[test]
    fn a_clock_set_back_restarts() {
        let mut instants = Instants::new(1, 10 * MS, 40 * MS);
        instants.sample(0, 5000 * MS, 1.0);
        assert_eq!(stamps(&instants.take()), [5000]);
        instants.sample(0, 1000 * MS, 2.0);
        assert_eq!(stamps(&instants.take()), [1000]);
    }

    #[test]
    fn when_all_stand_the_last_positions_hold() {
        let mut instants = Instants::new(2, 10 * MS, 40 * MS);
        instants.sample(0, 10 * MS, 1.0);
        instants.sample(1, 13 * MS, 2.0);
        assert!(instants.take().is_empty());
        let given = instants.all_stand(113 * MS);
        assert_eq!(
            given.last(),
            Some(&Instant { stamp_ns: 113 * MS, positions: vec![1.0, 2.0], skew_ns: 0 })
        );
        assert!(instants.all_stand(113 * MS).is_empty());
    }
}
