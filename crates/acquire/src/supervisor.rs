//! One supervisor for all devices.
//!
//! It starts sessions, waits between them (0.25 s, doubling to 10 s, back to 0.25 s only after a reading has proven
//! health), never retries a wrong device, lets cancellation win ties, counts and publishes every end, and turns lost
//! connections into recorded gaps.

mod axes_vigil;
mod link;
mod thermometers;
mod vigil;

pub use link::{Link, Outlet};

use crate::config::{DeviceConfig, channels};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use trunnion_core::Clock;
use trunnion_core::reading::Message;

const FIRST_WAIT: Duration = Duration::from_millis(250);
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// Messages between sessions and their reader: 2 s of four probes at 4 kHz.
pub const QUEUE_LENGTH: usize = 32_768;

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
    /// Another device answers; not retried.
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
    /// Names of the kinds, in the order of [`DeviceStatus::ends`].
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

/// The running acquisition.
pub struct Acquisition {
    /// Messages of all devices. When nobody takes them, they are dropped, counted, and a gap is sent.
    pub messages: mpsc::Receiver<Message>,
    /// Status of each device, in the order of the configuration.
    pub states: Vec<watch::Receiver<DeviceStatus>>,
    tasks: JoinSet<()>,
    cancel: CancellationToken,
}

impl Acquisition {
    /// Stops all sessions, waits for them, and gives back the messages not yet taken (last gaps included). Not
    /// cancel safe: dropped midway, the sessions still stop, but the messages are lost.
    pub async fn stop(mut self) -> Vec<Message> {
        self.cancel.cancel();
        while self.tasks.join_next().await.is_some() {}
        let mut rest = Vec::new();
        while let Ok(message) = self.messages.try_recv() {
            rest.push(message);
        }
        rest
    }
}

/// Starts a session for every device, on the current tokio runtime. Cancelling `cancel` stops them.
pub fn start(
    devices: Vec<DeviceConfig>,
    clock: Arc<dyn Clock>,
    cancel: CancellationToken,
    queue_length: usize,
) -> Acquisition {
    let (sender, messages) = mpsc::channel(queue_length.max(1));
    let all_channels = channels(&devices);
    let mut tasks = JoinSet::new();
    let mut states = Vec::new();
    for (index, config) in devices.into_iter().enumerate() {
        let device = index as u16;
        let (status, state) = watch::channel(DeviceStatus::default());
        states.push(state);
        let first_channel =
            all_channels.iter().position(|channel| channel.device == device).unwrap_or(0) as u16;
        let outlet = Outlet::new(device, config.name.clone(), sender.clone());
        let names = all_channels.iter().filter(|channel| channel.device == device);
        let names = names.map(|channel| channel.name.clone()).collect();
        let link = Link::new(first_channel, names, config.silence, clock.clone(), outlet, status);
        tasks.spawn(supervise(config, link, cancel.clone()));
    }
    Acquisition { messages, states, tasks, cancel }
}

async fn supervise(config: DeviceConfig, mut link: Link, cancel: CancellationToken) {
    let mut wait = FIRST_WAIT;
    loop {
        link.begin();
        let end = tokio::select! {
            biased;
            () = cancel.cancelled() => SessionEnd::Cancelled,
            ended = config.device.session(&mut link) => match ended {
                Err(end) => end,
            },
        };
        let end = if cancel.is_cancelled() { SessionEnd::Cancelled } else { end };
        if link.was_healthy() {
            wait = FIRST_WAIT;
        }
        link.ended(&end);
        match end {
            SessionEnd::Cancelled => return,
            SessionEnd::WrongDevice { .. } => {
                cancel.cancelled().await;
                link.ended(&SessionEnd::Cancelled);
                return;
            }
            _ => {}
        }
        tokio::select! {
            biased;
            () = cancel.cancelled() => {
                link.ended(&SessionEnd::Cancelled);
                return;
            }
            () = tokio::time::sleep(wait) => {}
        }
        wait = (wait * 2).min(LONGEST_WAIT);
    }
}
