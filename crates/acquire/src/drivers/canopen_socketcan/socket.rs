//! A CAN bus behind an interface of the kernel.

use super::interface::{self, refused};
use super::stamps::Stamps;
use crate::drivers::canopen::{Bus, BusEvent};
use crate::link::Link;
use crate::session_end::SessionEnd;
use socketcan::errors::ErrorCause;
use socketcan::tokio::CanSocket;
use socketcan::{CanError, CanFilter, EmbeddedFrame, Frame, Socket, SocketOptions};
use std::io;
use std::time::{Duration, UNIX_EPOCH};
use tokio::time::{Instant, sleep, timeout};
use trunnion_core::HostTime;
use trunnion_protocol::can::{CanFrame, CanId};
use trunnion_protocol::canopen::CobId;
use trunnion_protocol::canopen::network::sync_frame;

/// Longest wait for room in the transmit queue: ten frames on a bus of 10 kbit/s.
const WRITE_LIMIT: Duration = Duration::from_millis(200);
/// Wait before a frame is offered again to a full queue (ENOBUFS), which nothing announces.
const FULL_WAIT: Duration = Duration::from_millis(1);
/// How long an error of the bus is believed to last after the frame that reported it.
const FAULT_LASTS: Duration = Duration::from_secs(3);

/// Error numbers of Linux on every architecture it has CAN for but MIPS and SPARC, where the text alone is reported.
const ENXIO: i32 = 6;
const ENODEV: i32 = 19;
const EAFNOSUPPORT: i32 = 97;
const EPROTONOSUPPORT: i32 = 93;
const ENETDOWN: i32 = 100;
const ENOBUFS: i32 = 105;

/// An open interface.
pub(super) struct OpenInterface {
    name: String,
    socket: CanSocket,
    stamps: Stamps,
    /// SYNCs that have not come back; one whose echo was lost stays in it.
    syncs_under_way: u32,
    foreign_sync_reported: bool,
    fault: Option<(Instant, String)>,
}

impl OpenInterface {
    /// Opens the interface: own frames come back, errors of the bus come as frames, everything is stamped.
    pub(super) fn open(name: &str) -> Result<Self, SessionEnd> {
        // Any interface: fails where the kernel knows no CAN at all.
        socketcan::CanSocket::open_iface(0).map_err(|error| no_socketcan(name, &error))?;
        interface::check(name)?;
        let socket = CanSocket::open(name).map_err(|error| failed(name, "opening", &error))?;
        socket
            .set_recv_own_msgs(true)
            .and_then(|()| socket.set_error_filter_accept_all())
            .and_then(|()| socket.set_recv_timestamp(true))
            .map_err(|error| failed(name, "setting up", &error))?;
        Ok(Self {
            name: name.into(),
            socket,
            stamps: Stamps::default(),
            syncs_under_way: 0,
            foreign_sync_reported: false,
            fault: None,
        })
    }

    fn event(&mut self, frame: socketcan::CanFrame, at: HostTime) -> Result<Option<BusEvent>, SessionEnd> {
        if let socketcan::CanFrame::Error(error) = frame {
            return self.bus_error(error.into_error());
        }
        let Some(frame) = from_kernel(&frame) else { return Ok(None) };
        if frame.id() != CobId::Sync.can_id() {
            return Ok(Some(BusEvent::Frame { frame, at }));
        }
        if let Some(left) = self.syncs_under_way.checked_sub(1) {
            self.syncs_under_way = left;
            return Ok(Some(BusEvent::SyncSent { at: Some(at) }));
        }
        let reported = std::mem::replace(&mut self.foreign_sync_reported, true);
        Ok((!reported).then(|| BusEvent::Remark {
            warning: true,
            text: format!(
                "somebody else sends SYNC on {}; values may belong to other moments than recorded. Switch the other \
                 SYNC producer off (object 1005h bit 30)",
                self.name
            ),
        }))
    }

    fn bus_error(&mut self, error: CanError) -> Result<Option<BusEvent>, SessionEnd> {
        if error.is_bus_off() {
            return Err(interface::bus_off(&self.name));
        }
        if error.is_restarted() {
            self.fault = None;
            let text = format!("{} was restarted after bus-off", self.name);
            return Ok(Some(BusEvent::Remark { warning: true, text }));
        }
        // Counters and lost arbitration are everyday matters.
        let serious = |cause: &&ErrorCause| {
            !matches!(cause, ErrorCause::Counters { .. } | ErrorCause::LostArbitration(_))
        };
        let reported: Vec<String> = error.causes().filter(serious).map(ToString::to_string).collect();
        if reported.is_empty() {
            return Ok(None);
        }
        let advice = if error.is_no_ack() {
            "no node acknowledges: is one switched on, with this bit rate, on a terminated bus?"
        } else {
            "check cable, both 120 Ω terminators and the bit rate"
        };
        let text = format!("{} reports {}; {advice}", self.name, reported.join(", "));
        let now = Instant::now();
        let known = self.fault.replace((now, text.clone()));
        let news = known.is_none_or(|(at, before)| before != text || now - at > FAULT_LASTS);
        Ok(news.then_some(BusEvent::Remark { warning: true, text }))
    }

    /// Hands a frame to the kernel; a full queue is waited for, with a limit.
    async fn write(&mut self, frame: CanFrame) -> Result<(), SessionEnd> {
        let frame = to_kernel(&frame).ok_or_else(|| SessionEnd::Protocol {
            doing: "sending a frame",
            fault: format!("{frame:?} is none the kernel can send"),
        })?;
        let deadline = Instant::now() + WRITE_LIMIT;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            match timeout(left, self.socket.write_frame(frame)).await {
                Ok(Ok(())) => return Ok(()),
                Ok(Err(error)) if error.raw_os_error() == Some(ENOBUFS) && !left.is_zero() => {
                    sleep(FULL_WAIT).await;
                }
                Ok(Err(error)) if error.raw_os_error() != Some(ENOBUFS) => {
                    return Err(failed(&self.name, "writing to", &error));
                }
                Ok(Err(_)) | Err(_) => {
                    let why =
                        self.fault().unwrap_or_else(|| "no node acknowledges, or the bus is full".into());
                    return Err(SessionEnd::Disconnected(format!(
                        "{} has taken no frame for {} ms; {why}",
                        self.name,
                        WRITE_LIMIT.as_millis()
                    )));
                }
            }
        }
    }
}

impl Bus for OpenInterface {
    const SYNCS_UNDER_WAY: u64 = 1;

    fn hear(&mut self, ids: &[CanId]) -> Result<(), SessionEnd> {
        let filters: Vec<CanFilter> = ids.iter().map(|id| exactly(*id)).collect();
        self.socket.set_filters(&filters).map_err(|error| failed(&self.name, "setting up", &error))
    }

    async fn send(&mut self, frame: CanFrame) -> Result<(), SessionEnd> {
        self.write(frame).await
    }

    async fn send_sync(&mut self) -> Result<(), SessionEnd> {
        self.syncs_under_way = self.syncs_under_way.saturating_add(1);
        self.write(sync_frame(None)).await
    }

    async fn receive(&mut self, limit: Duration, link: &Link) -> Result<Vec<BusEvent>, SessionEnd> {
        let (frame, stamp) = match timeout(limit, self.socket.read_frame_with_timestamp()).await {
            Err(_) => return Ok(Vec::new()),
            Ok(Err(error)) => return Err(failed(&self.name, "reading", &error)),
            Ok(Ok(read)) => read,
        };
        let stamp_ns = stamp.duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
        let stamp_ns = i64::try_from(stamp_ns).unwrap_or(i64::MAX);
        let stamped = self.stamps.convert(stamp_ns, link.clock());
        let step = stamped.step_ns.map(|step_ns| BusEvent::Remark {
            warning: true,
            text: format!(
                "the wall clock was set by {:.3} s; stamps of {} in that moment may be some ms off",
                step_ns as f64 * 1e-9,
                self.name
            ),
        });
        let event = self.event(frame, stamped.at)?.map(|event| match event {
            BusEvent::SyncSent { .. } if !stamped.trusted => BusEvent::SyncSent { at: None },
            event => event,
        });
        Ok(step.into_iter().chain(event).collect())
    }

    async fn tend(&mut self) -> Result<(), SessionEnd> {
        // The kernel reports on its own.
        Ok(())
    }

    fn fault(&self) -> Option<String> {
        self.fault.as_ref().filter(|(at, _)| at.elapsed() < FAULT_LASTS).map(|(_, text)| text.clone())
    }

    fn dropped_bytes(&self) -> u64 {
        0
    }
}

fn no_socketcan(name: &str, error: &io::Error) -> SessionEnd {
    match error.raw_os_error() {
        Some(EAFNOSUPPORT | EPROTONOSUPPORT) => refused(
            name,
            &format!(
                "this kernel has no SocketCAN ({error}); load it with `modprobe can_raw`, take a kernel that has it \
                 (Debian: linux-image-amd64, not the cloud flavour), or use a serial adapter with driver \
                 canopen-slcan"
            ),
        ),
        _ => failed(name, "opening", error),
    }
}

fn failed(name: &str, doing: &str, error: &io::Error) -> SessionEnd {
    match error.raw_os_error() {
        Some(ENODEV | ENXIO) => interface::absent(name),
        Some(ENETDOWN) => interface::down(name),
        _ if error.kind() == io::ErrorKind::PermissionDenied => refused(
            name,
            &format!("{doing} it: {error}; under systemd allow AF_CAN in RestrictAddressFamilies="),
        ),
        _ => SessionEnd::Disconnected(format!("{doing} {name}: {error}")),
    }
}

/// Frames of one identifier; 29 bits are marked by a flag (`CAN_EFF_FLAG` of linux/can.h).
fn exactly(id: CanId) -> CanFilter {
    const LONG: u32 = 0x8000_0000;
    match id {
        CanId::Standard(_) => CanFilter::new(id.raw(), LONG | 0x7FF),
        CanId::Extended(_) => CanFilter::new(LONG | id.raw(), LONG | 0x1FFF_FFFF),
    }
}

fn to_kernel(frame: &CanFrame) -> Option<socketcan::CanFrame> {
    use socketcan::{CanFrame as Kernel, ExtendedId, Id, StandardId};
    let id: Id = match frame.id() {
        CanId::Standard(id) => StandardId::new(id)?.into(),
        CanId::Extended(id) => ExtendedId::new(id)?.into(),
    };
    if frame.is_remote() { Kernel::new_remote(id, frame.dlc()) } else { Kernel::new(id, frame.data()) }
}

/// `None` for what no classical frame can be.
fn from_kernel(frame: &socketcan::CanFrame) -> Option<CanFrame> {
    let id = match frame.raw_id() {
        raw if frame.is_extended() => CanId::Extended(raw),
        raw => CanId::Standard(u16::try_from(raw).ok()?),
    };
    let made = if frame.is_remote_frame() {
        CanFrame::remote_request(id, frame.dlc())
    } else {
        CanFrame::data_frame(id, frame.data())
    };
    made.ok()
}
