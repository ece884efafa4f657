//! An emulated adapter: which commands its state allows and how it answers them (CAN232 manual, command list).

use super::{AdapterMessage, Bitrate, HostCommand, StatusFlags};
use crate::can::CanFrame;

/// State of an emulated adapter: which commands it takes and how it answers them.
#[derive(Debug, Clone, Default)]
pub struct Adapter {
    bitrate: Option<Bitrate>,
    open: bool,
    listen_only: bool,
    time_stamps: bool,
    status: StatusFlags,
}

impl Adapter {
    /// The answer to one command, and the frame to put on the bus if there is one. `None` stands for a line that
    /// was no command.
    pub fn answer(&mut self, command: Option<HostCommand>) -> (Option<AdapterMessage>, Option<CanFrame>) {
        use AdapterMessage::{Accepted, Done, Refused};
        let accept = |ok: bool| Some(if ok { Done } else { Refused });
        match command {
            None => (Some(Refused), None),
            Some(HostCommand::Empty) => (None, None),
            Some(HostCommand::SetBitrate(rate)) => {
                if !self.open {
                    self.bitrate = Some(rate);
                }
                (accept(!self.open), None)
            }
            Some(command @ (HostCommand::Open | HostCommand::Listen)) => {
                let ok = self.bitrate.is_some() && !self.open;
                if ok {
                    self.open = true;
                    self.listen_only = command == HostCommand::Listen;
                }
                (accept(ok), None)
            }
            Some(HostCommand::Close) => (accept(std::mem::take(&mut self.open)), None),
            Some(HostCommand::TimeStamps(on)) => {
                if !self.open {
                    self.time_stamps = on;
                }
                (accept(!self.open), None)
            }
            Some(HostCommand::Status) if self.open => (Some(AdapterMessage::Status(self.status.0)), None),
            Some(HostCommand::Status) => (Some(Refused), None),
            Some(HostCommand::Version) => (Some(AdapterMessage::Version("1013".into())), None),
            Some(HostCommand::SerialNumber) => (Some(AdapterMessage::SerialNumber("T001".into())), None),
            Some(HostCommand::Transmit(frame)) if self.open && !self.listen_only && !self.is_bus_off() => {
                (Some(Accepted), Some(frame))
            }
            Some(HostCommand::Transmit(_)) => (Some(Refused), None),
        }
    }

    /// The line for a frame seen on the bus at `clock_ms` of the adapter; nothing while closed.
    pub fn receive(&self, frame: CanFrame, clock_ms: u64) -> Option<AdapterMessage> {
        let stamp_ms = self.time_stamps.then_some((clock_ms % 60_000) as u16);
        (self.open && !self.is_bus_off()).then_some(AdapterMessage::Frame { frame, stamp_ms })
    }

    /// What `F` reports from now on. While it is [`StatusFlags::BUS_OFF`] no frame goes out or comes in.
    pub fn set_status(&mut self, status: StatusFlags) {
        self.status = status;
    }

    fn is_bus_off(&self) -> bool {
        self.status == StatusFlags::BUS_OFF
    }

    /// The bit rate set by the host, if any.
    pub fn bitrate(&self) -> Option<Bitrate> {
        self.bitrate
    }

    /// True between `O` or `L` and `C`.
    pub fn is_open(&self) -> bool {
        self.open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::can::CanId;
    use crate::slcan::AdapterDecoder;

    fn frame(id: u16, data: &[u8]) -> CanFrame {
        CanFrame::data_frame(CanId::Standard(id), data).unwrap()
    }

    #[test]
    fn an_adapter_refuses_what_its_state_forbids() {
        let mut adapter = Adapter::default();
        let mut say = |text: &[u8]| -> Vec<_> {
            AdapterDecoder::default().push(text).into_iter().map(|c| adapter.answer(c).0).collect()
        };
        let (done, refused) = (Some(AdapterMessage::Done), Some(AdapterMessage::Refused));
        assert_eq!(say(b"\r\rO\r"), [None, None, refused.clone()]);
        assert_eq!(
            say(b"S8\rZ1\rO\rO\rS4\r"),
            [done.clone(), done.clone(), done.clone(), refused.clone(), refused.clone()]
        );
        assert_eq!(say(b"t1232AA\rt1232AABB\r"), [refused, Some(AdapterMessage::Accepted)]);
        assert_eq!(
            adapter.receive(frame(1, &[]), 60_001),
            Some(AdapterMessage::Frame { frame: frame(1, &[]), stamp_ms: Some(1) })
        );
    }
}
