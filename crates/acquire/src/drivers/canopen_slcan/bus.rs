//! The CAN bus behind an slcan adapter.

use crate::supervisor::{Link, SessionEnd};
use crate::transport::serial::{self, Port};
use std::time::Duration;
use tokio::time::Instant;
use trunnion_protocol::can::CanFrame;
use trunnion_protocol::canopen::{NodeDescription, NodeId, NodeStartup, StartupProgress};
use trunnion_protocol::slcan::{AdapterMessage, Bitrate, HostCommand, HostDecoder};

/// Adapters answer within some ms; USB adds 16.
const ADAPTER_LIMIT: Duration = Duration::from_millis(300);
/// Longest wait for one SDO answer.
const SDO_LIMIT: Duration = Duration::from_millis(500);

/// An open adapter.
pub(super) struct Bus {
    port: Port,
    decoder: HostDecoder,
    buffer: Box<[u8; 8192]>,
}

impl Bus {
    /// Closes (it may be open from before), sets the bit rate, opens.
    pub(super) async fn open(
        name: &str,
        baud: u32,
        bitrate: Bitrate,
        link: &mut Link,
    ) -> Result<Self, SessionEnd> {
        let (port, remark) = serial::open(name, baud)?;
        if let Some(remark) = remark {
            link.log(true, remark);
        }
        let mut bus = Self { port, decoder: HostDecoder::default(), buffer: Box::new([0; 8192]) };
        // Two empty lines end whatever is in the adapter's buffer; the answers up to here mean nothing.
        let (empty, close) = (HostCommand::Empty.encode(), HostCommand::Close.encode());
        bus.port.write(&[empty.clone(), empty, close].concat()).await?;
        while bus.port.read(bus.buffer.as_mut_slice(), Duration::from_millis(50)).await?.is_some() {}
        let version = bus.command(HostCommand::Version).await?;
        bus.command(HostCommand::SetBitrate(bitrate)).await?;
        let opened = bus.command(HostCommand::Open).await?;
        if version.is_none() && opened.is_none() {
            let who = format!("{name} does not answer as an slcan adapter");
            return Err(SessionEnd::Silent { who, waited: 3 * ADAPTER_LIMIT });
        }
        if opened == Some(AdapterMessage::Refused) {
            link.log(true, "the adapter refused to open, it may be open already; going on".into());
        }
        Ok(bus)
    }

    /// The adapter's answer; none when it keeps quiet, as some do.
    async fn command(&mut self, command: HostCommand) -> Result<Option<AdapterMessage>, SessionEnd> {
        self.port.write(&command.encode()).await?;
        let deadline = Instant::now() + ADAPTER_LIMIT;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let messages = self.receive(left).await?;
            if messages.is_empty() && Instant::now() >= deadline {
                return Ok(None);
            }
            let answer =
                messages.into_iter().find(|message| !matches!(message, AdapterMessage::Frame { .. }));
            if answer.is_some() {
                return Ok(answer);
            }
        }
    }

    pub(super) async fn send(&mut self, frame: CanFrame) -> Result<(), SessionEnd> {
        self.port.write(&HostCommand::Transmit(frame).encode()).await
    }

    /// What the next bytes complete; empty after `limit`. Cancel safe.
    pub(super) async fn receive(&mut self, limit: Duration) -> Result<Vec<AdapterMessage>, SessionEnd> {
        let count = self.port.read(self.buffer.as_mut_slice(), limit).await?;
        Ok(count.map_or_else(Vec::new, |count| self.decoder.push(&self.buffer[..count])))
    }

    /// Waits a moment for the adapter to take what was sent last; what else comes meanwhile is dropped.
    pub(super) async fn wait_accepted(&mut self) -> Result<(), SessionEnd> {
        let deadline = Instant::now() + ADAPTER_LIMIT;
        while Instant::now() < deadline {
            let left = deadline.saturating_duration_since(Instant::now());
            if self.receive(left).await?.contains(&AdapterMessage::Accepted) {
                break;
            }
        }
        Ok(())
    }

    pub(super) fn dropped_bytes(&self) -> u64 {
        self.decoder.losses().dropped_bytes
    }

    /// Reads what the node says about itself.
    pub(super) async fn describe(&mut self, node: NodeId) -> Result<NodeDescription, SessionEnd> {
        let (mut startup, request) = NodeStartup::new(node);
        self.send(request).await?;
        let mut deadline = Instant::now() + SDO_LIMIT;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let messages = self.receive(left).await?;
            if messages.is_empty() && Instant::now() >= deadline {
                let who = format!("CANopen node {} does not answer for {}", node.get(), startup.reading());
                self.send(startup.give_up()).await?;
                return Err(SessionEnd::Silent { who, waited: SDO_LIMIT });
            }
            for message in messages {
                let AdapterMessage::Frame { frame, .. } = message else { continue };
                match startup.on_frame(&frame) {
                    StartupProgress::NotMine => {}
                    StartupProgress::Send(next) => {
                        self.send(next).await?;
                        deadline = Instant::now() + SDO_LIMIT;
                    }
                    StartupProgress::Done(description) => return Ok(*description),
                    StartupProgress::Failed { error, abort } => {
                        if let Some(abort) = abort {
                            self.send(abort).await?;
                        }
                        let cause =
                            std::error::Error::source(&error).map_or(String::new(), |c| format!(": {c}"));
                        return Err(SessionEnd::Protocol {
                            doing: "reading a node's description",
                            fault: format!("{error}{cause}"),
                        });
                    }
                }
            }
        }
    }
}
