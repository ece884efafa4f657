//! Lines of both sides, and frames in them.

use crate::can::{CanFrame, CanId};
use std::fmt::Write;

pub(super) const CR: u8 = b'\r';

pub(super) const BEL: u8 = 0x07;

/// Longer than any line of the protocol (extended frame with stamp: 30); beyond it a line is garbage.
pub(super) const MAX_LINE: usize = 64;

/// Nominal bit rate, named by its digit in the `S` command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Bitrate {
    /// 10 kbit/s, `S0`.
    K10,
    /// 20 kbit/s, `S1`.
    K20,
    /// 50 kbit/s, `S2`.
    K50,
    /// 100 kbit/s, `S3`.
    K100,
    /// 125 kbit/s, `S4`.
    K125,
    /// 250 kbit/s, `S5`.
    K250,
    /// 500 kbit/s, `S6`.
    K500,
    /// 800 kbit/s, `S7`.
    K800,
    /// 1 Mbit/s, `S8`.
    K1000,
}

impl Bitrate {
    /// Every bit rate, in the order of the `S` digit.
    pub const ALL: [Bitrate; 9] = [
        Bitrate::K10,
        Bitrate::K20,
        Bitrate::K50,
        Bitrate::K100,
        Bitrate::K125,
        Bitrate::K250,
        Bitrate::K500,
        Bitrate::K800,
        Bitrate::K1000,
    ];

    /// Bits per second.
    pub fn bits_per_s(self) -> u32 {
        [10, 20, 50, 100, 125, 250, 500, 800, 1000][self as usize] * 1000
    }
}

/// What a host says to an adapter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostCommand {
    /// An empty line: hosts send a few to clear the adapter's buffer.
    Empty,
    /// `Sn`: set the bit rate; only while closed.
    SetBitrate(Bitrate),
    /// `O`: open for reception and transmission.
    Open,
    /// `L`: open for listening only.
    Listen,
    /// `C`: close.
    Close,
    /// `Z1` or `Z0`: frames carry time stamps or not; only while closed.
    TimeStamps(bool),
    /// `F`: read the status flags; only while open.
    Status,
    /// `V`: read the version.
    Version,
    /// `N`: read the serial number.
    SerialNumber,
    /// `t`, `T`, `r`, `R`: send a frame; only while open.
    Transmit(CanFrame),
}

impl HostCommand {
    /// The bytes on the wire, CR included.
    pub fn encode(&self) -> Vec<u8> {
        let mut line = match self {
            HostCommand::Empty => String::new(),
            HostCommand::SetBitrate(rate) => format!("S{}", *rate as u8),
            HostCommand::Open => "O".into(),
            HostCommand::Listen => "L".into(),
            HostCommand::Close => "C".into(),
            HostCommand::TimeStamps(on) => format!("Z{}", u8::from(*on)),
            HostCommand::Status => "F".into(),
            HostCommand::Version => "V".into(),
            HostCommand::SerialNumber => "N".into(),
            HostCommand::Transmit(frame) => frame_text(frame),
        };
        line.push('\r');
        line.into_bytes()
    }

    pub(super) fn from_line(line: &[u8]) -> Option<Self> {
        Some(match line {
            [] => HostCommand::Empty,
            [b'S', digit @ b'0'..=b'8'] => HostCommand::SetBitrate(Bitrate::ALL[usize::from(digit - b'0')]),
            [b'O'] => HostCommand::Open,
            [b'L'] => HostCommand::Listen,
            [b'C'] => HostCommand::Close,
            [b'Z', digit @ (b'0' | b'1')] => HostCommand::TimeStamps(*digit == b'1'),
            [b'F'] => HostCommand::Status,
            [b'V'] => HostCommand::Version,
            [b'N'] => HostCommand::SerialNumber,
            _ => match parse_frame(line)? {
                (frame, []) => HostCommand::Transmit(frame),
                _ => return None,
            },
        })
    }
}

/// What an adapter says to a host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum AdapterMessage {
    /// CR alone: the command was done.
    Done,
    /// BEL: the command was refused.
    Refused,
    /// `z` or `Z`: the frame was taken for transmission.
    Accepted,
    /// A frame from the bus, with the adapter's clock in ms modulo 60 000 when stamps are on.
    Frame {
        /// The frame.
        frame: CanFrame,
        /// Adapter clock, ms modulo 60 000.
        stamp_ms: Option<u16>,
    },
    /// `Fxx`: status flags (bit 2 error warning, bit 3 overrun, bit 5 error passive, bit 7 bus error).
    Status(u8),
    /// `V…`: hardware and software version as sent, `1013` for example.
    Version(String),
    /// `N…`: serial number as sent.
    SerialNumber(String),
}

impl AdapterMessage {
    /// The bytes on the wire, CR or BEL included.
    pub fn encode(&self) -> Vec<u8> {
        let mut line = match self {
            AdapterMessage::Done => String::new(),
            AdapterMessage::Refused => return vec![BEL],
            AdapterMessage::Accepted => "z".into(),
            AdapterMessage::Frame { frame, stamp_ms } => {
                let stamp = stamp_ms.map(|ms| format!("{ms:04X}")).unwrap_or_default();
                frame_text(frame) + &stamp
            }
            AdapterMessage::Status(flags) => format!("F{flags:02X}"),
            AdapterMessage::Version(text) => format!("V{text}"),
            AdapterMessage::SerialNumber(text) => format!("N{text}"),
        };
        line.push('\r');
        line.into_bytes()
    }

    pub(super) fn from_line(line: &[u8]) -> Option<Self> {
        Some(match line {
            [] => AdapterMessage::Done,
            [b'z' | b'Z'] => AdapterMessage::Accepted,
            [b'F', high, low] => AdapterMessage::Status(hex_number(&[*high, *low])? as u8),
            [b'V', rest @ ..] => AdapterMessage::Version(printable(rest)?),
            [b'N', rest @ ..] => AdapterMessage::SerialNumber(printable(rest)?),
            _ => match parse_frame(line)? {
                (frame, []) => AdapterMessage::Frame { frame, stamp_ms: None },
                (frame, stamp) if stamp.len() == 4 => {
                    AdapterMessage::Frame { frame, stamp_ms: Some(hex_number(stamp)? as u16) }
                }
                _ => return None,
            },
        })
    }
}

/// The flags of `F` (CAN232 manual, command F): bit 0 receive queue full, 1 transmit queue full, 2 error warning, 3
/// data overrun, 5 error passive, 6 arbitration lost, 7 bus error. Bus-off has none of its own: the controller is
/// then error passive and takes no more frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatusFlags(pub u8);

impl StatusFlags {
    /// Error warning, error passive, bus error and a full transmit queue: bus-off.
    pub const BUS_OFF: Self = Self(0b1010_0110);

    /// What is wrong with the bus, in words.
    pub fn bus_trouble(self) -> Option<String> {
        let named =
            [(1, "transmit queue full"), (2, "error warning"), (5, "error passive"), (7, "bus error")];
        let set: Vec<&str> =
            named.into_iter().filter(|(bit, _)| self.0 >> bit & 1 != 0).map(|(_, name)| name).collect();
        (!set.is_empty()).then(|| format!("{} (status {:02X}h)", set.join(", "), self.0))
    }

    /// Bit 3 or 0: frames from the bus were lost.
    pub fn has_lost_frames(self) -> bool {
        self.0 & 0b1001 != 0
    }
}

/// What could not be decoded so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Losses {
    /// Lines, or pieces cut off by a BEL, that are no message of the protocol.
    pub bad_lines: u64,
    /// Bytes in those lines.
    pub dropped_bytes: u64,
}

/// Splits the host's end of the stream into messages of the adapter.
#[derive(Debug, Clone, Default)]
pub struct HostDecoder {
    pub(super) lines: LineBuffer,
}

impl HostDecoder {
    /// Takes bytes as read and returns the messages they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<AdapterMessage> {
        let mut messages = Vec::new();
        for &byte in bytes {
            match byte {
                // Lines are short; a BEL inside one means its rest was lost.
                BEL => {
                    self.lines.discard();
                    messages.push(AdapterMessage::Refused);
                }
                CR => messages.extend(self.lines.end(AdapterMessage::from_line)),
                _ => self.lines.keep(byte),
            }
        }
        messages
    }

    /// What was dropped since the start.
    pub fn losses(&self) -> Losses {
        self.lines.losses
    }
}

/// Splits the adapter's end of the stream into commands of the host. A line that is no command gives `None`: the
/// adapter answers it with [`AdapterMessage::Refused`].
#[derive(Debug, Clone, Default)]
pub struct AdapterDecoder {
    pub(super) lines: LineBuffer,
}

impl AdapterDecoder {
    /// Takes bytes as read and returns the commands they complete, `None` for a line that is none.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Option<HostCommand>> {
        let mut commands = Vec::new();
        for &byte in bytes {
            match byte {
                CR => commands.push(self.lines.end(HostCommand::from_line)),
                _ => self.lines.keep(byte),
            }
        }
        commands
    }

    /// What was dropped since the start.
    pub fn losses(&self) -> Losses {
        self.lines.losses
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct LineBuffer {
    pub(super) line: Vec<u8>,
    /// Bytes beyond [`MAX_LINE`] are counted, not kept.
    pub(super) overflow: u64,
    pub(super) losses: Losses,
}

impl LineBuffer {
    pub(super) fn keep(&mut self, byte: u8) {
        if byte == b'\n' && self.line.is_empty() && self.overflow == 0 {
            return; // adapters that end lines in CR LF
        }
        if self.line.len() < MAX_LINE { self.line.push(byte) } else { self.overflow += 1 }
    }

    pub(super) fn end<T>(&mut self, parse: impl Fn(&[u8]) -> Option<T>) -> Option<T> {
        let message = if self.overflow == 0 { parse(&self.line) } else { None };
        if message.is_none() {
            self.discard();
        }
        self.line.clear();
        message
    }

    pub(super) fn discard(&mut self) {
        let dropped = self.line.len() as u64 + self.overflow;
        self.losses.bad_lines += u64::from(dropped > 0);
        self.losses.dropped_bytes += dropped;
        self.line.clear();
        self.overflow = 0;
    }
}

pub(super) fn frame_text(frame: &CanFrame) -> String {
    let (data_letter, remote_letter, id) = match frame.id() {
        CanId::Standard(id) => ('t', 'r', format!("{id:03X}")),
        CanId::Extended(id) => ('T', 'R', format!("{id:08X}")),
    };
    let mut text = String::with_capacity(32);
    text.push(if frame.is_remote() { remote_letter } else { data_letter });
    text.push_str(&id);
    write!(text, "{}", frame.dlc()).expect("writing to a string cannot fail");
    for byte in frame.data() {
        write!(text, "{byte:02X}").expect("writing to a string cannot fail");
    }
    text
}

/// A frame at the start of a line, and what follows it.
pub(super) fn parse_frame(line: &[u8]) -> Option<(CanFrame, &[u8])> {
    let (&letter, rest) = line.split_first()?;
    let (id, rest) = match letter {
        b't' | b'r' => {
            let (digits, rest) = rest.split_at_checked(3)?;
            (CanId::Standard(hex_number(digits)? as u16), rest)
        }
        b'T' | b'R' => {
            let (digits, rest) = rest.split_at_checked(8)?;
            (CanId::Extended(hex_number(digits)?), rest)
        }
        _ => return None,
    };
    let (&length, rest) = rest.split_first()?;
    let length = usize::from(length.checked_sub(b'0')?);
    if length > 8 {
        return None;
    }
    if matches!(letter, b'r' | b'R') {
        return Some((CanFrame::remote_request(id, length).ok()?, rest));
    }
    let (digits, rest) = rest.split_at_checked(2 * length)?;
    let mut data = [0; 8];
    for (byte, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = hex_number(pair)? as u8;
    }
    Some((CanFrame::data_frame(id, &data[..length]).ok()?, rest))
}

/// At most eight hex digits, nothing else.
pub(super) fn hex_number(digits: &[u8]) -> Option<u32> {
    digits.iter().try_fold(0, |number, &digit| Some(number << 4 | char::from(digit).to_digit(16)?))
}

pub(super) fn printable(bytes: &[u8]) -> Option<String> {
    bytes.iter().all(u8::is_ascii_graphic).then(|| bytes.iter().map(|&byte| char::from(byte)).collect())
}
