//! What a measured cycle comes to.

use trunnion_core::{Gap, Quality};
use trunnion_sync::EndReason;

/// How a measured cycle ended.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Points recorded. They are not kept: a cycle may last for hours.
    pub points: Counted,
    /// Why it ended.
    pub reason: EndReason,
    /// Holes in what was asked; the recording holds all, those while the ball was mounted again too.
    pub gaps: Vec<Gap>,
    /// Most messages that waited to be taken.
    pub most_waiting: usize,
}

/// Points of a cycle by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Good ones.
    pub read: u64,
    /// Without a reading that settled.
    pub unsettled: u64,
    /// Poses that were not stood at, or without a value of every probe.
    pub missing: u64,
}

impl Counted {
    pub(super) fn count(&mut self, quality: Quality) {
        *match quality {
            Quality::Good => &mut self.read,
            Quality::Unsettled => &mut self.unsettled,
            Quality::NoReading(_) => &mut self.missing,
        } += 1;
    }
}
