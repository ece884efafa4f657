//! Why a session ended.

use std::time::Duration;

/// Why a session ended.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionEnd {
    /// The port or address is not there.
    #[error("{address} is not there; {remedy}")]
    Absent {
        /// Port, interface or address, with the system's words where it has some.
        address: String,
        /// What to do, as fits the address.
        remedy: &'static str,
    },
    /// The port hung up or the peer closed the connection.
    #[error("disconnected: {0}")]
    Disconnected(String),
    /// Nothing came for too long.
    #[error("silent for {} ms: {who}", waited.as_millis())]
    Silent {
        /// Who was to send.
        who: String,
        /// How long was waited.
        waited: Duration,
    },
    /// Another device answers, in its own well-formed words; asked again once a minute.
    #[error("wrong device: found {found}, expected {expected}; correct the port or the configuration")]
    WrongDevice {
        /// What answers.
        found: String,
        /// What the configuration says.
        expected: String,
    },
    /// The device does not keep to the protocol.
    #[error("{doing}: {fault}")]
    Protocol {
        /// What was being done.
        doing: &'static str,
        /// What was wrong, with its causes.
        fault: String,
    },
    /// The agent or node was restarted: what was read from it no longer holds.
    #[error("restarted: {0}")]
    Restarted(String),
    /// The system does not let us: permission, or in use.
    #[error("cannot open {address}: {why}")]
    Refused {
        /// Port or address.
        address: String,
        /// The system's words.
        why: String,
    },
    /// We were asked to stop.
    #[error("stopped")]
    Cancelled,
}

impl SessionEnd {
    /// Names of the kinds, in the order of `DeviceStatus::ends`.
    pub const KINDS: [&'static str; 8] =
        ["absent", "disconnected", "silent", "wrong-device", "protocol", "restarted", "refused", "cancelled"];

    /// Index into [`SessionEnd::KINDS`].
    pub fn kind(&self) -> usize {
        match self {
            Self::Absent { .. } => 0,
            Self::Disconnected(_) => 1,
            Self::Silent { .. } => 2,
            Self::WrongDevice { .. } => 3,
            Self::Protocol { .. } => 4,
            Self::Restarted(_) => 5,
            Self::Refused { .. } => 6,
            Self::Cancelled => 7,
        }
    }
}
