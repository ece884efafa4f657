//! Words of the matrix: the fault of a device, and what must follow.

use std::future::Future;
use std::net::SocketAddr;
use std::pin::Pin;
use trunnion_acquire::DeviceState;
use trunnion_hil_sim::devices::{Fault, Handle};

use super::bench::Floor;
pub use super::common::Kind;

/// A fault of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    AbsentAtStart,
    Unplugged,
    Silent,
    Garbled,
    WrongIdentity,
    StuckValue,
    OutOfRange,
    CounterJump,
    ClockJump,
    BusOff,
    Restarted,
    ControllerGone,
}

impl Trouble {
    pub const ALL: [Self; 12] = [
        Self::AbsentAtStart,
        Self::Unplugged,
        Self::Silent,
        Self::Garbled,
        Self::WrongIdentity,
        Self::StuckValue,
        Self::OutOfRange,
        Self::CounterJump,
        Self::ClockJump,
        Self::BusOff,
        Self::Restarted,
        Self::ControllerGone,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::AbsentAtStart => "absent at start",
            Self::Unplugged => "unplugged",
            Self::Silent => "silent",
            Self::Garbled => "garbled",
            Self::WrongIdentity => "wrong identity",
            Self::StuckValue => "stuck value",
            Self::OutOfRange => "out of range",
            Self::CounterJump => "counter jump",
            Self::ClockJump => "clock jump",
            Self::BusOff => "bus-off",
            Self::Restarted => "restarted",
            Self::ControllerGone => "controller gone",
        }
    }
}

/// One driver with the virtual device it reads.
pub struct Subject {
    /// Name of the driver.
    pub driver: &'static str,
    /// The device in words.
    pub about: &'static str,
    /// Keys of its `[[device]]` table; `{port}` stands for the serial port, `{tcp}` for the port on TCP.
    pub keys: &'static str,
    /// Switches the device on; one on TCP listens at the address.
    pub start: fn(Floor, SocketAddr) -> Starting,
    /// What it has in common with others.
    pub kind: Kind,
    /// What follows from a trouble, where it is its own.
    pub own: fn(Trouble) -> Option<Cell>,
}

impl Subject {
    /// What follows from a trouble.
    pub fn cell(&self, trouble: Trouble) -> Cell {
        (self.own)(trouble)
            .or_else(|| self.kind.cell(trouble))
            .unwrap_or_else(|| panic!("{} has no cell for: {}", self.driver, trouble.name()))
    }
}

/// A device being switched on.
pub type Starting = Pin<Box<dyn Future<Output = Handle> + Send>>;

/// One cell of the matrix.
pub enum Cell {
    /// This device cannot have it, because.
    Cannot(&'static str),
    /// This must follow.
    Case(Case),
}

/// What is done and what must follow. In texts `*` stands for anything.
#[derive(Clone)]
pub struct Case {
    /// None: the device is switched on only after the program has found it absent.
    pub fault: Option<Fault>,
    /// The device has been read for so long before, s, and so many readings have come.
    pub after_s: f64,
    pub after_readings: u64,
    /// States from the fault on: each of them, no other, the first and the last in their places. Empty: it goes on
    /// streaming.
    pub course: &'static [DeviceState],
    /// A state that is not seen each time, and when it is.
    pub perhaps: Option<(DeviceState, &'static str)>,
    /// The gap that is recorded.
    pub gap: Option<GapOf>,
    /// What is reported in addition to the gap; empty where the gap says all.
    pub message: String,
}

impl Case {
    /// True for a state that may be seen or not.
    pub fn may_be(&self, state: DeviceState) -> bool {
        self.perhaps.is_some_and(|(perhaps, _)| perhaps == state)
    }
}

/// A recorded gap.
#[derive(Clone)]
pub struct GapOf {
    /// Its source, where it is a channel and not the device itself.
    pub channel: Option<&'static str>,
    pub reason: String,
    pub lost: Lost,
    /// At least so long, s.
    pub at_least_s: f64,
}

impl GapOf {
    /// The whole device was away for so long.
    pub fn away(reason: &str, at_least_s: f64) -> Option<Self> {
        Some(Self { channel: None, reason: reason.into(), lost: Lost::NotCounted, at_least_s })
    }

    /// The device reported how many were lost, or they can be counted here.
    pub fn counted(reason: &str) -> Option<Self> {
        Self::without_value(None, reason, 0.0)
    }

    /// Readings of a channel came without value for so long.
    pub fn without_value(channel: Option<&'static str>, reason: &str, at_least_s: f64) -> Option<Self> {
        Some(Self { channel, reason: reason.into(), lost: Lost::Counted, at_least_s })
    }
}

/// Readings that are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lost {
    /// Nobody counts them: the gap has a time only.
    NotCounted,
    /// So many.
    Exactly(u64),
    /// Counted, at least one.
    Counted,
}

impl Lost {
    pub fn fits(self, lost: Option<u64>) -> bool {
        match self {
            Self::NotCounted => lost.is_none(),
            Self::Exactly(count) => lost == Some(count),
            Self::Counted => lost.is_some_and(|count| count > 0),
        }
    }
}
