//! What a device is doing.

use crate::session_end::SessionEnd;

/// What a device is doing, for the status page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeviceState {
    /// Its port or address is not there. A state, not a failure.
    #[default]
    Absent,
    /// A session is opening and identifying it.
    Connecting,
    /// Readings arrive.
    Streaming,
    /// Readings arrive, but the number of a channel does not change any more; they carry no value until it does.
    Stuck,
    /// It was there and stopped sending.
    Silent,
    /// The connection was lost or failed; the next attempt waits.
    Failed,
    /// Another device answers; a person must act.
    WrongDevice,
    /// The system does not let us open it.
    Refused,
    /// The program is stopping.
    Stopped,
}

/// State of a device with its history.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeviceStatus {
    /// Now.
    pub state: DeviceState,
    /// What the device said of itself, empty until identified.
    pub identity: String,
    /// Connections begun.
    pub epoch: u32,
    /// How often sessions ended, by kind ([`SessionEnd::KINDS`]).
    pub ends: [u64; 8],
    /// The last end.
    pub last_end: Option<SessionEnd>,
    /// Messages of this device lost because nobody took them in time.
    pub lost_messages: u64,
}
