//! Axes that do not move while their program goes on.
//!
//! Standing is what axes do at every pose, so positions alone never say that they are stuck. A program that runs from
//! block to block without any motion does.

use std::time::Duration;
use trunnion_core::reading::{AxisReading, ControllerReading, Execution, Reading};
use trunnion_core::{AxisValues, HostTime};

/// Blocks without motion: more than a program has between two poses (stop, message, dwell, feed).
const MOST_BLOCKS: u32 = 6;
/// And at least so long: blocks that only compute are quick.
const AT_LEAST: Duration = Duration::from_secs(2);

/// What was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxesFinding {
    /// No motion since then.
    Stuck {
        /// Last motion.
        since: HostTime,
        /// Blocks executed since.
        blocks: u32,
    },
    /// They move again.
    Moving {
        /// Last motion before.
        since: HostTime,
    },
}

/// Watches one controller.
#[derive(Debug, Default)]
pub(crate) struct AxisWatchdog {
    last: Option<(AxisValues<f64>, HostTime)>,
    block: String,
    blocks: u32,
    stuck: bool,
}

impl AxisWatchdog {
    pub(crate) fn see(&mut self, reading: &Reading, at: HostTime) -> Option<AxesFinding> {
        match reading {
            Reading::Axes(axes) => self.axes(axes, at),
            Reading::Controller(controller) => self.controller(controller, at),
            _ => None,
        }
    }

    pub(crate) fn is_stuck(&self) -> bool {
        self.stuck
    }

    fn axes(&mut self, axes: &AxisReading, at: HostTime) -> Option<AxesFinding> {
        let (position, since) = *self.last.get_or_insert((axes.position, at));
        if position == axes.position {
            return None;
        }
        self.last = Some((axes.position, at));
        self.blocks = 0;
        std::mem::take(&mut self.stuck).then_some(AxesFinding::Moving { since })
    }

    fn controller(&mut self, now: &ControllerReading, at: HostTime) -> Option<AxesFinding> {
        let goes_on = now.execution == Execution::Active && now.block != self.block;
        self.block.clone_from(&now.block);
        if !goes_on {
            return None;
        }
        self.blocks += 1;
        let (_, since) = self.last?;
        if self.stuck || self.blocks <= MOST_BLOCKS || at - since < AT_LEAST {
            return None;
        }
        self.stuck = true;
        Some(AxesFinding::Stuck { since, blocks: self.blocks })
    }
}
