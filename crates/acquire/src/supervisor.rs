//! One supervisor for all devices.
//!
//! It starts sessions, waits between them (0.25 s, doubling to 10 s, back to 0.25 s only after a reading has proven
//! health), asks a wrong device again once a minute, lets cancellation win ties, counts and publishes every end, and turns
//! lost connections into recorded gaps.

use crate::config::{DeviceConfig, channels};
use crate::link::{Link, Outlet};
use crate::session_end::SessionEnd;
use crate::status::DeviceStatus;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::task::JoinSet;
use tokio_util::sync::CancellationToken;
use trunnion_core::reading::Message;
use trunnion_core::{Clock, Role};

const FIRST_WAIT: Duration = Duration::from_millis(250);
const LONGEST_WAIT: Duration = Duration::from_secs(10);
/// A wrong device stays one until a person changes something: often enough to see the right cable back, too seldom to disturb.
const WRONG_DEVICE_WAIT: Duration = Duration::from_secs(60);
/// Messages between sessions and their reader: 2 s of four probes at 4 kHz.
pub const QUEUE_LENGTH: usize = 32_768;

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
        let mut link = Link::new(first_channel, names, config.silence, clock.clone(), outlet, status);
        let bar = all_channels.iter().position(|c| c.device == device && c.role == Role::Bar);
        link.set_bar_zero(bar.map(|bar| bar as u16).zip(config.device.bar_zero_mm()));
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
        let pause = match end {
            SessionEnd::Cancelled => return,
            SessionEnd::WrongDevice { .. } => WRONG_DEVICE_WAIT,
            _ => wait,
        };
        tokio::select! {
            biased;
            () = cancel.cancelled() => {
                link.ended(&SessionEnd::Cancelled);
                return;
            }
            () = tokio::time::sleep(pause) => {}
        }
        wait = (wait * 2).min(LONGEST_WAIT);
    }
}
