//! What can go wrong with a device, on command or at a time set beforehand.

use super::clock::TimeOrigin;
use super::world::mix;
use tokio::sync::mpsc;

/// A fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// The next bytes the device sends are damaged.
    GarbleBytes {
        /// How many.
        count: usize,
    },
    /// The device says nothing and hears nothing; its clock and counters go on. At an agent, or a server next to the
    /// controller: the link to the controller is lost, every data item becomes `UNAVAILABLE` or bad.
    Silence {
        /// How long, s.
        duration_s: f64,
    },
    /// The cable is pulled and put back: the port vanishes, its users are hung up, a new port appears under the same
    /// name. At the agent: the network is gone, connections are dropped and new ones refused.
    Unplug {
        /// How long, s.
        duration_s: f64,
    },
    /// The network freezes: connections stay and carry nothing, new ones are taken and hear nothing.
    Freeze {
        /// How long, s.
        duration_s: f64,
    },
    /// The agent or server is restarted: connections dropped, new identity of the instance, sequence numbers from 1.
    AgentRestart,
    /// Another device takes the place of this one: it answers in the same way, with another identity.
    WrongIdentity,
    /// The device goes on sending the value it had.
    StuckValue {
        /// How long, s.
        duration_s: f64,
    },
    /// What is measured lies outside the range of the device, which says so in the way of its kind.
    OutOfRange {
        /// How long, s.
        duration_s: f64,
    },
    /// The count of measurements jumps: measurements were made that nobody sent.
    CounterJump {
        /// By how many.
        by: u32,
    },
    /// The clock of the device is reset.
    ClockJump {
        /// By how much, s; negative sets it back.
        by_s: f64,
    },
    /// The CAN controller of the adapter goes bus-off: nothing is sent or received until it is restarted.
    BusOff {
        /// How long, s.
        duration_s: f64,
    },
}

impl Fault {
    /// True when its duration, if it has one, is a time.
    pub(super) fn is_possible(&self) -> bool {
        match self {
            Fault::Silence { duration_s }
            | Fault::Unplug { duration_s }
            | Fault::Freeze { duration_s }
            | Fault::StuckValue { duration_s }
            | Fault::OutOfRange { duration_s }
            | Fault::BusOff { duration_s } => duration_s.is_finite() && *duration_s >= 0.0,
            Fault::ClockJump { by_s } => by_s.is_finite(),
            Fault::GarbleBytes { .. }
            | Fault::AgentRestart
            | Fault::WrongIdentity
            | Fault::CounterJump { .. } => true,
        }
    }

    /// True for what happens on the line, whatever device hangs on it.
    pub(super) fn is_of_the_line(&self) -> bool {
        matches!(self, Fault::GarbleBytes { .. } | Fault::Silence { .. } | Fault::Unplug { .. })
    }
}

/// Damages the next `left` bytes, each differently and none to itself; `position` is that of the first in the stream.
pub(super) fn damage(bytes: &mut [u8], left: &mut usize, position: u64) {
    let count = bytes.len().min(*left);
    *left -= count;
    for (byte, k) in bytes[..count].iter_mut().zip(position..) {
        *byte ^= (mix(k) % 255) as u8 + 1;
    }
}

/// What happens to one reply on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReplyFault {
    /// It leaves so much later, s.
    Late(f64),
    /// It comes twice.
    Doubled,
    /// It does not come; over HTTP and OPC UA its connection is closed instead.
    Dropped,
    /// Only its first half comes; over HTTP and OPC UA its connection is closed then.
    Cut,
    /// It leaves together with the next one.
    Merged,
}

/// A fault at a time of the cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduledFault {
    /// When, in time of the cell, s.
    pub at_s: f64,
    /// What.
    pub fault: Fault,
}

/// Faults of one device, scheduled and commanded, in the order they happen.
#[derive(Debug)]
pub(super) struct FaultSource {
    origin: TimeOrigin,
    /// Latest first.
    scheduled: Vec<ScheduledFault>,
    commanded: mpsc::Receiver<Fault>,
}

impl FaultSource {
    pub fn new(origin: TimeOrigin, scheduled: &[ScheduledFault], commanded: mpsc::Receiver<Fault>) -> Self {
        let mut scheduled = scheduled.to_vec();
        scheduled.sort_by(|a, b| b.at_s.total_cmp(&a.at_s));
        Self { origin, scheduled, commanded }
    }

    /// The next fault, when it happens. Cancel safe: a fault is taken only when it is given out.
    pub async fn next(&mut self) -> Fault {
        let Some(next) = self.scheduled.last().copied() else {
            return commanded(&mut self.commanded).await;
        };
        tokio::select! {
            biased;
            fault = commanded(&mut self.commanded) => fault,
            () = tokio::time::sleep_until(self.origin.instant_of(next.at_s)) => {
                self.scheduled.pop();
                next.fault
            }
        }
    }
}

/// A commanded fault; never when nobody is left to command one.
async fn commanded(queue: &mut mpsc::Receiver<Fault>) -> Fault {
    match queue.recv().await {
        Some(fault) => fault,
        None => std::future::pending().await,
    }
}
