//! Whether a program that runs again after an unasked stop goes on or begins from its top.

use trunnion_core::HostTime;
use trunnion_core::reading::{ControllerReading, Execution};

/// A program that stopped without having been asked to, and neither runs nor is reset for so long, is over, s: as long as a
/// static cycle waits for motion ([`crate::StaticRules`]).
const STOPPED_S: f64 = 120.0;

/// What a report says of the program's way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// Nothing new.
    AsBefore,
    /// It runs again after an unasked stop, from an earlier block.
    FromTheTop,
    /// It runs again after an unasked stop; the blocks do not show from where.
    FromSomewhere,
}

/// A program as last reported.
#[derive(Clone, Debug, Default)]
pub(super) struct Program {
    execution: Execution,
    /// Number of its block when it last ran.
    block: Option<u64>,
    /// It stopped unasked and was neither reset nor seen running since.
    after_stop: bool,
    /// Since when it is stopped.
    stopped: Option<HostTime>,
}

impl Program {
    pub(super) fn take(&mut self, now: &ControllerReading) -> Way {
        match now.execution {
            Execution::Unknown => return Way::AsBefore,
            Execution::Stopped => {
                self.stopped.get_or_insert(now.arrival);
                self.after_stop = true;
            }
            Execution::Held | Execution::Ready | Execution::Ended | Execution::Active => self.stopped = None,
        }
        self.execution = now.execution;
        if matches!(now.execution, Execution::Held | Execution::Stopped) {
            return Way::AsBefore;
        }
        let again = std::mem::take(&mut self.after_stop) && now.execution == Execution::Active;
        let was_at = std::mem::replace(&mut self.block, number(&now.block));
        match (was_at, self.block) {
            _ if !again => Way::AsBefore,
            (Some(was_at), Some(is_at)) if is_at < was_at => Way::FromTheTop,
            (Some(_), Some(_)) => Way::AsBefore,
            _ => Way::FromSomewhere,
        }
    }

    /// It waits for a person, or for what stopped it.
    pub(super) fn is_held(&self) -> bool {
        matches!(self.execution, Execution::Held | Execution::Stopped)
    }

    /// It stopped so long ago that it is over; reported once.
    pub(super) fn has_given_up(&mut self, now: HostTime) -> bool {
        self.stopped.take_if(|since| now.seconds_since(*since) >= STOPPED_S).is_some()
    }
}

/// Number at the beginning of a block, `N120 G1` or `120`.
fn number(block: &str) -> Option<u64> {
    let text = block.trim_start();
    let text = text.strip_prefix(['N', 'n']).unwrap_or(text);
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    text[..end].parse().ok()
}
