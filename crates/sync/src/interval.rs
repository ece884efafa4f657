//! How often a channel is read, from its samples: what is a hole for fast probes is the usual pace of an indicator that is asked
//! ten times a second.

use std::cmp::Ordering;

/// Longest distance of two samples that is no hole, s, for channels read as often as probes usually are.
pub(crate) const USUAL_GAP_S: f64 = 0.05;
/// A channel read more slowly may lack one reading, and its stamps may be off by half an interval.
const INTERVALS: f64 = 2.5;
/// The median of so many is not moved by the holes that a loss leaves.
const KEPT: usize = 9;

/// The usual distance of the samples of one channel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    newest_s: f64,
    latest: [f64; KEPT],
    count: usize,
    usual_s: f64,
}

impl Default for Interval {
    fn default() -> Self {
        Self { newest_s: f64::NAN, latest: [f64::INFINITY; KEPT], count: 0, usual_s: 0.0 }
    }
}

impl Interval {
    /// Takes the time of the next sample.
    pub(crate) fn push(&mut self, time_s: f64) {
        let apart_s = time_s - self.newest_s;
        self.newest_s = time_s;
        // Samples of one moment say nothing of the pace; the first has none before it.
        if apart_s.partial_cmp(&0.0) != Some(Ordering::Greater) {
            return;
        }
        self.latest[self.count % KEPT] = apart_s;
        self.count += 1;
        let mut sorted = self.latest;
        sorted.sort_unstable_by(f64::total_cmp);
        self.usual_s = sorted[(self.count.min(KEPT) - 1) / 2];
    }

    /// The usual distance, s; 0 before the second sample.
    pub(crate) fn usual_s(&self) -> f64 {
        self.usual_s
    }

    /// Longest distance of two samples that is no hole, s; never shorter than `least_s`.
    pub(crate) fn longest_gap_s(&self, least_s: f64) -> f64 {
        least_s.max(INTERVALS * self.usual_s)
    }
}

#[cfg(test)]
mod tests {
    use super::{Interval, USUAL_GAP_S};

    #[test]
    fn a_loss_leaves_the_usual_interval_as_it_is() {
        let mut interval = Interval::default();
        (0..20).filter(|k| *k != 9 && *k != 10).for_each(|k| interval.push(0.1 * f64::from(k)));
        assert!((interval.longest_gap_s(USUAL_GAP_S) - 0.25).abs() < 1e-9);
    }

    #[test]
    fn fast_probes_keep_the_limit_they_had() {
        let mut interval = Interval::default();
        (0..20).for_each(|k| interval.push(0.015 * f64::from(k)));
        assert_eq!(interval.longest_gap_s(USUAL_GAP_S), USUAL_GAP_S);
    }
}
