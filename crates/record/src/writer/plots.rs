//! Which samples are written a second time, as numbers that any viewer draws.

use crate::wire::Topic;
use std::collections::HashMap;

/// Shortest time between two samples for viewers, s.
const STEP_S: f64 = 0.01;

/// Time of the last sample of each topic that was written so, s.
#[derive(Default)]
pub(super) struct Plots(HashMap<Topic, f64>);

impl Plots {
    /// True when this sample is the next one.
    pub fn is_due(&mut self, topic: Topic, time_s: f64) -> bool {
        let last = self.0.entry(topic).or_insert(f64::NEG_INFINITY);
        let is_due = time_s - *last >= STEP_S;
        if is_due {
            *last = time_s;
        }
        is_due
    }
}
