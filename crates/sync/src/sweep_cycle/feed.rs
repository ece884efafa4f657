//! Where a pass goes at its feed, without the run-in before and the run-out behind, by the rule that forms points.

use super::pace::{HALF_S, Pace};
use super::rules::SweepRules;
use crate::align::AxisState;
use std::ops::Range;
use trunnion_core::{AxisSample, AxisValues};
use trunnion_cycles::cycle::Sweep;

/// The samples of one pass from the first to the last that goes at `feed_rad_per_s`, which is the commanded feed times its override.
/// Next to a ramp the speed is that of a window which holds a part of it, so that half a window more is left out there. `angle_rad` is
/// where each sample is on its course. What an axis does in between is its error, also where it leaves the feed. `None` where
/// no sample goes at the feed.
pub fn at_feed(
    rules: &SweepRules,
    samples: &[AxisSample],
    angle_rad: &[f64],
    feed_rad_per_s: f64,
) -> Option<Range<usize>> {
    let rules = SweepRules { passes: vec![Sweep { setup: 0, feed_rad_per_s }], ..rules.clone() };
    let mut pace = Pace::default();
    for (sample, angle) in samples.iter().zip(angle_rad) {
        pace.push(&state(sample), *angle);
    }
    let goes = |sample: &AxisSample| {
        pace.motion(sample.time_s).is_some_and(|motion| rules.feed_of(&motion).is_some())
    };
    let (first, last) = (samples.iter().position(goes)?, samples.iter().rposition(goes)?);
    let margin_s = |is_ramp: bool| if is_ramp { HALF_S } else { 0.0 };
    let from_s = samples[first].time_s + margin_s(first > 0);
    let to_s = samples[last].time_s - margin_s(last + 1 < samples.len());
    let begin = samples.partition_point(|sample| sample.time_s < from_s);
    let end = samples.partition_point(|sample| sample.time_s <= to_s);
    (begin < end).then_some(begin..end)
}

fn state(sample: &AxisSample) -> AxisState {
    let none = AxisValues::default();
    AxisState {
        time_s: sample.time_s,
        position: sample.position,
        velocity: none,
        acceleration: none,
        direction: none,
        since_reversal: none,
    }
}
