//! Which pass of a cycle on the fly a sample belongs to.
//!
//! Passes come in the order of the cycle. A new one begins when the axis turns at the feed of a later pass, or when it is
//! back where the present one began. A pass that nobody saw (a device was away) is passed over; a pass seen too early (a
//! positioning move at a feed of the cycle) does not end the wait for those before it.

use crate::cycle_event::Progress;
use trunnion_cycles::cycle::Sweep;

/// A pass counts as swept from this share of the span.
const SWEPT: f64 = 0.98;
/// Back by this share of the span is a pass of its own.
const BACK: f64 = 0.5;

/// Where in the cycle the machine is.
#[derive(Clone, Debug)]
pub(super) struct Passes {
    plan: Vec<Sweep>,
    from_to_rad: (f64, f64),
    /// The present pass; `None` before the first.
    at: Option<usize>,
    /// How far each pass came, rad from where it begins; `None` for one not seen yet.
    reached_rad: Vec<Option<f64>>,
}

impl Passes {
    pub(super) fn new(plan: Vec<Sweep>, from_to_rad: (f64, f64)) -> Self {
        let reached_rad = vec![None; plan.len()];
        Self { plan, from_to_rad, at: None, reached_rad }
    }

    /// The pass of a sample taken at a feed of the cycle (rad/s, signed) and an angle in its span (rad); `None` when
    /// no pass is left for it.
    pub(super) fn take(&mut self, feed_rad_per_s: f64, angle_rad: f64) -> Option<usize> {
        let (low, high) = self.ends();
        let travelled = if feed_rad_per_s > 0.0 { angle_rad - low } else { high - angle_rad };
        let Some(at) = self.find(feed_rad_per_s, travelled) else {
            if self.at.is_some_and(|at| self.is_at_feed(at, feed_rad_per_s)) {
                // The last pass once more: its end is not the end of the pass before.
                self.at = Some(self.plan.len());
            }
            return None;
        };
        if self.at != Some(at) {
            self.reached_rad[at] = None;
            self.at = Some(at);
        }
        self.reached_rad[at] = Some(self.reached_rad[at].map_or(travelled, |reached| reached.max(travelled)));
        Some(at)
    }

    fn find(&self, feed_rad_per_s: f64, travelled_rad: f64) -> Option<usize> {
        let fits = |k: &usize| self.is_at_feed(*k, feed_rad_per_s);
        let goes_on = |k: &usize| {
            let reached = self.reached_rad[*k].unwrap_or(travelled_rad);
            travelled_rad > reached - BACK * self.span_rad()
        };
        let unseen = |k: &usize| self.reached_rad[*k].is_none();
        let later = self.at.map_or(0, |at| at + 1).min(self.plan.len())..self.plan.len();
        self.at
            .filter(|at| fits(at) && goes_on(at))
            .or_else(|| later.clone().find(fits))
            .or_else(|| (0..later.start).find(|k| fits(k) && unseen(k)))
    }

    fn is_at_feed(&self, pass: usize, feed_rad_per_s: f64) -> bool {
        self.plan.get(pass).is_some_and(|pass| pass.feed_rad_per_s == feed_rad_per_s)
    }

    pub(super) fn progress(&self) -> Progress {
        let span = self.span_rad();
        let reached = || self.reached_rad.iter().map(|reached| reached.unwrap_or(0.0));
        let done = reached().filter(|angle| *angle >= SWEPT * span).count();
        let left = |(pass, angle): (&Sweep, f64)| (span - angle).max(0.0) / pass.feed_rad_per_s.abs();
        let seconds_left = self.plan.iter().zip(reached()).map(left).sum();
        Progress { done, total: self.plan.len(), seconds_left: Some(seconds_left) }
    }

    fn ends(&self) -> (f64, f64) {
        (self.from_to_rad.0.min(self.from_to_rad.1), self.from_to_rad.0.max(self.from_to_rad.1))
    }

    fn span_rad(&self) -> f64 {
        let (low, high) = self.ends();
        (high - low).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(plan: &[(usize, f64)]) -> Passes {
        let sweep = |&(setup, feed_rad_per_s): &(usize, f64)| Sweep { setup, feed_rad_per_s };
        Passes::new(plan.iter().map(sweep).collect(), (0.0, 2.0))
    }

    /// The passes that a sweep between two angles is counted to.
    fn run(passes: &mut Passes, feed: f64, from: f64, to: f64) -> Vec<Option<usize>> {
        let at = |k: usize| from + (to - from) * k as f64 / 100.0;
        let mut seen: Vec<_> = (0..=100).map(|k| passes.take(feed, at(k))).collect();
        seen.dedup();
        seen
    }

    #[test]
    fn setups_rounds_and_directions_follow_the_order_of_the_cycle() {
        // Two setups that stay mounted, two rounds.
        let plan = [(0, 1.0), (1, 1.0), (0, -1.0), (1, -1.0)].repeat(2);
        let mut passes = passes(&plan);
        for round in 0..2 {
            for (k, feed) in [1.0, 1.0, -1.0, -1.0].into_iter().enumerate() {
                let (from, to) = if feed > 0.0 { (0.0, 2.0) } else { (2.0, 0.0) };
                assert_eq!(run(&mut passes, feed, from, to), [Some(4 * round + k)]);
            }
        }
        assert_eq!((passes.progress().done, passes.progress().total), (8, 8));
        assert_eq!(run(&mut passes, -1.0, 2.0, 0.0), [None], "no pass is left");
        assert_eq!(run(&mut passes, 1.0, 0.0, 2.0), [None], "no pass is left");
    }

    #[test]
    fn a_cycle_of_one_direction_takes_no_point_on_the_way_back() {
        let mut passes = passes(&[(0, 1.0), (0, 1.0)]);
        assert_eq!(run(&mut passes, 1.0, 0.0, 2.0), [Some(0)]);
        assert_eq!(run(&mut passes, -1.0, 2.0, 0.0), [None]);
        assert_eq!(run(&mut passes, 1.0, 0.0, 2.0), [Some(1)]);
    }

    #[test]
    fn a_pass_held_half_way_goes_on_as_the_same_pass() {
        let mut passes = passes(&[(0, 1.0), (1, 1.0)]);
        assert_eq!(run(&mut passes, 1.0, 0.0, 1.0), [Some(0)]);
        assert_eq!(run(&mut passes, 1.0, 1.0, 2.0), [Some(0)]);
    }

    #[test]
    fn a_lost_pass_is_passed_over_and_a_positioning_move_is_not_waited_for() {
        let plan = [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)];
        let mut lost = passes(&plan);
        assert_eq!(run(&mut lost, -1.0, 2.0, 0.0), [Some(1)]);
        assert_eq!(run(&mut lost, 1.0, 0.0, 2.0), [Some(2)]);
        let plan = [(0, 0.5), (0, -0.5), (0, 1.0), (0, -1.0)];
        let mut moved = passes(&plan);
        run(&mut moved, -1.0, 1.6, 0.0);
        for (k, (_, feed)) in plan.into_iter().enumerate() {
            let (from, to) = if feed > 0.0 { (0.0, 2.0) } else { (2.0, 0.0) };
            assert_eq!(run(&mut moved, feed, from, to), [Some(k)]);
        }
    }
}
