//! A CAN bus behind an slcan adapter.

use crate::drivers::canopen::{Bus, BusEvent};
use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::serial;
use crate::transport::serial::{Framing, Port};
use std::collections::VecDeque;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_core::HostTime;
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::network::sync_frame;
use trunnion_protocol::slcan::{AdapterMessage, Bitrate, HostCommand, HostDecoder, StatusFlags};

/// Adapters answer within some ms; USB adds 16.
const ADAPTER_LIMIT: Duration = Duration::from_millis(300);
/// Commands whose answers are waited for; an adapter that answers nothing fills the list.
const MOST_UNDER_WAY: usize = 512;

/// An open adapter.
pub(super) struct OpenAdapter {
    port: Port,
    decoder: HostDecoder,
    buffer: Box<[u8; 8192]>,
    /// Commands not yet answered, oldest first.
    under_way: VecDeque<UnderWay>,
    acknowledges: bool,
    /// False once the adapter has refused to report its status.
    reports_status: bool,
    status: StatusFlags,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnderWay {
    Frame,
    Sync,
    Status,
}

impl OpenAdapter {
    /// Closes (it may be open from before), sets the bit rate, opens.
    pub(super) async fn open(
        name: &str,
        baud: u32,
        bitrate: Bitrate,
        link: &mut Link,
    ) -> Result<Self, SessionEnd> {
        let (mut adapter, version, _) = Self::closed(name, baud, bitrate, link).await?;
        let opened = adapter.command(HostCommand::Open).await?;
        if version.is_none() && opened.is_none() {
            return Err(adapter.port.no_answer("as an slcan adapter", 3 * ADAPTER_LIMIT));
        }
        if opened == Some(AdapterMessage::Refused) {
            link.log(true, "the adapter refused to open, it may be open already; going on".into());
        }
        Ok(adapter)
    }

    /// The same without a word on the bus, which at another bit rate would disturb it; none where the adapter does not say that it
    /// took bit rate and `L`: what it would hear then says nothing.
    pub(super) async fn listen(
        name: &str,
        baud: u32,
        bitrate: Bitrate,
        link: &mut Link,
    ) -> Result<Option<Self>, SessionEnd> {
        let (mut adapter, _, bitrate_set) = Self::closed(name, baud, bitrate, link).await?;
        let opened = adapter.command(HostCommand::Listen).await?;
        if [bitrate_set, opened].iter().all(|answer| *answer == Some(AdapterMessage::Done)) {
            return Ok(Some(adapter));
        }
        adapter.close().await?;
        Ok(None)
    }

    /// Leaves the bus.
    pub(super) async fn close(mut self) -> Result<(), SessionEnd> {
        self.command(HostCommand::Close).await.map(|_| ())
    }

    /// Not yet open, with the answers to version and bit rate.
    async fn closed(
        name: &str,
        baud: u32,
        bitrate: Bitrate,
        link: &mut Link,
    ) -> Result<(Self, Option<AdapterMessage>, Option<AdapterMessage>), SessionEnd> {
        let port = serial::open(name, baud, Framing::PLAIN, link)?;
        let mut adapter = Self {
            port,
            decoder: HostDecoder::default(),
            buffer: Box::new([0; 8192]),
            under_way: VecDeque::new(),
            acknowledges: false,
            reports_status: true,
            status: StatusFlags::default(),
        };
        // Two empty lines end whatever is in the adapter's buffer; the answers up to here mean nothing.
        let (empty, close) = (HostCommand::Empty.encode(), HostCommand::Close.encode());
        adapter.port.write(&[empty.clone(), empty, close].concat()).await?;
        while adapter.port.read(adapter.buffer.as_mut_slice(), Duration::from_millis(50)).await?.is_some() {}
        let version = adapter.command(HostCommand::Version).await?;
        let bitrate_set = adapter.command(HostCommand::SetBitrate(bitrate)).await?;
        Ok((adapter, version, bitrate_set))
    }

    /// The adapter's answer; none when it keeps quiet, as some do.
    async fn command(&mut self, command: HostCommand) -> Result<Option<AdapterMessage>, SessionEnd> {
        self.port.write(&command.encode()).await?;
        let deadline = Instant::now() + ADAPTER_LIMIT;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let messages = self.messages(left).await?;
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

    async fn messages(&mut self, limit: Duration) -> Result<Vec<AdapterMessage>, SessionEnd> {
        let count = self.port.read(self.buffer.as_mut_slice(), limit).await?;
        Ok(count.map_or_else(Vec::new, |count| self.decoder.push(&self.buffer[..count])))
    }

    async fn ask(&mut self, command: HostCommand, kind: UnderWay) -> Result<(), SessionEnd> {
        if self.under_way.len() == MOST_UNDER_WAY {
            self.under_way.pop_front();
        }
        self.under_way.push_back(kind);
        self.port.write(&command.encode()).await
    }

    fn events(&mut self, message: AdapterMessage, at: HostTime) -> Vec<BusEvent> {
        let event = match message {
            AdapterMessage::Frame { frame, .. } => Some(BusEvent::Frame { frame, at }),
            AdapterMessage::Accepted => {
                self.acknowledges = true;
                (self.under_way.pop_front() == Some(UnderWay::Sync))
                    .then_some(BusEvent::SyncSent { at: None })
            }
            AdapterMessage::Refused => self.refused(),
            AdapterMessage::Status(flags) => return self.reported_status(StatusFlags(flags)),
            AdapterMessage::Done | AdapterMessage::Version(_) | AdapterMessage::SerialNumber(_) => None,
        };
        event.into_iter().collect()
    }

    fn refused(&mut self) -> Option<BusEvent> {
        // An adapter that acknowledges nothing can only mean the one command that has an answer.
        let meant = if !self.acknowledges && self.under_way.contains(&UnderWay::Status) {
            Some(UnderWay::Status)
        } else {
            self.under_way.pop_front()
        };
        match meant? {
            UnderWay::Frame => None,
            UnderWay::Sync => Some(BusEvent::SyncRefused),
            UnderWay::Status => {
                self.reports_status = false;
                None
            }
        }
    }

    fn reported_status(&mut self, status: StatusFlags) -> Vec<BusEvent> {
        // What was asked before and is not answered yet never will be: its answer was lost on the line. SYNCs among it
        // were sent all the same, and later values must not be taken for theirs.
        let asked = self.under_way.iter().position(|kind| *kind == UnderWay::Status);
        let unanswered = self.under_way.drain(..asked.map_or(0, |index| index + 1));
        let lost_syncs = unanswered.filter(|kind| *kind == UnderWay::Sync).count();
        let acknowledges = self.acknowledges;
        let mut events: Vec<BusEvent> =
            (0..lost_syncs).filter(|_| acknowledges).map(|_| BusEvent::SyncRefused).collect();
        events.extend(self.changed_status(status));
        events
    }

    fn changed_status(&mut self, status: StatusFlags) -> Option<BusEvent> {
        if status.has_lost_frames() {
            let text = "the adapter lost frames of the bus; use a faster port, or send fewer SYNCs".into();
            return Some(BusEvent::Remark { warning: true, text });
        }
        let before = std::mem::replace(&mut self.status, status);
        (before.bus_trouble() != status.bus_trouble()).then(|| match self.fault() {
            Some(text) => BusEvent::Remark { warning: true, text },
            None => BusEvent::Remark { warning: false, text: "the bus is free of errors again".into() },
        })
    }
}

impl Bus for OpenAdapter {
    // Fewer than the moments that are kept.
    const SYNCS_UNDER_WAY: u64 = 200;

    fn hear(&mut self, _: &[CanId]) -> Result<(), SessionEnd> {
        // Acceptance filters of adapters differ, and some have none.
        Ok(())
    }

    async fn send(&mut self, frame: CanFrame) -> Result<(), SessionEnd> {
        self.ask(HostCommand::Transmit(frame), UnderWay::Frame).await
    }

    async fn send_sync(&mut self) -> Result<(), SessionEnd> {
        self.ask(HostCommand::Transmit(sync_frame(None)), UnderWay::Sync).await
    }

    async fn receive(&mut self, limit: Duration, link: &Link) -> Result<Vec<BusEvent>, SessionEnd> {
        let messages = self.messages(limit).await?;
        let at = link.now();
        Ok(messages.into_iter().flat_map(|message| self.events(message, at)).collect())
    }

    async fn tend(&mut self) -> Result<(), SessionEnd> {
        if self.reports_status && !self.under_way.contains(&UnderWay::Status) {
            self.ask(HostCommand::Status, UnderWay::Status).await?;
        }
        Ok(())
    }

    fn fault(&self) -> Option<String> {
        self.status.bus_trouble().map(|trouble| {
            format!(
                "the adapter on {} reports {trouble}: check cable, both 120 Ω terminators, the bit rate, and that \
                 a node is switched on",
                self.port.name()
            )
        })
    }

    fn dropped_bytes(&self) -> u64 {
        self.decoder.losses().dropped_bytes
    }
}
