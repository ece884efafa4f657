//! Samples at no feed of the cycle: of a pass, or on the way to where one begins.
//!
//! A stretch is what the machine goes one way without standing. It is of a pass where it reaches a feed, goes on the same way from where it was at
//! one, or passes through the whole span. One that does none of this is the way to a pass, or home from it: its samples are not asked for.

use super::rules::{GOES_ON_RAD, SweepRules};

/// The stretch under way.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretch {
    /// −1 or 1; 0 standing, or going a way that no pass goes.
    way: f64,
    is_of_pass: bool,
    /// Samples at no feed that wait for what the stretch is, and the angles between which they lie.
    waiting: u64,
    low_high: Option<(f64, f64)>,
    /// Angle and way of the last sample at a feed.
    at_feed: Option<(f64, f64)>,
}

impl Stretch {
    /// Takes the next sample; the number of samples at no feed that are now known to be of a pass.
    pub(super) fn take(&mut self, rules: &SweepRules, (way, angle): (f64, f64), is_at_feed: bool) -> u64 {
        let mut known = 0;
        if way != self.way {
            known += self.end(rules);
            self.way = way;
            self.is_of_pass =
                self.at_feed.is_some_and(|(last, its)| its == way && (angle - last).abs() < GOES_ON_RAD);
        }
        if is_at_feed {
            self.is_of_pass = true;
            self.at_feed = Some((angle, way));
        } else if way != 0.0 && rules.holds(angle) {
            self.waiting += 1;
            let (low, high) = self.low_high.unwrap_or((angle, angle));
            self.low_high = Some((low.min(angle), high.max(angle)));
        }
        if self.is_of_pass {
            known += std::mem::take(&mut self.waiting);
        }
        known
    }

    /// Ends it; the samples at no feed that were of a pass all the same.
    pub(super) fn end(&mut self, rules: &SweepRules) -> u64 {
        let (from, to) = rules.span();
        let is_whole = |(low, high): (f64, f64)| low - from < GOES_ON_RAD && to - high < GOES_ON_RAD;
        let is_of_pass = self.low_high.take().is_some_and(is_whole);
        let waiting = std::mem::take(&mut self.waiting);
        if is_of_pass { waiting } else { 0 }
    }
}
