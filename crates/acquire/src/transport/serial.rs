//! Serial ports, opened exclusively.
//!
//! A port that hung up reads zero bytes for ever (Linux) or EIO (pty): both are a disconnection. A pseudo-terminal
//! takes only some line speeds and needs none: where a speed is refused the port is opened at 115 200 baud and the
//! refusal is reported. A pseudo-terminal is always 8N1, so a 7-bit format must not rely on the port to take the parity
//! bit away.

use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::trouble;
use std::fmt;
use std::path::Path;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::timeout;
use tokio_serial::{DataBits, Parity, SerialPortBuilderExt, SerialStream, StopBits};
use trunnion_core::input::Table;

/// A write that takes longer means a stuck adapter.
const WRITE_LIMIT: Duration = Duration::from_secs(1);
/// A line speed every port takes.
const PLAIN_BAUD: u32 = 115_200;

/// How bits make bytes on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Framing {
    /// Seven bits of data instead of eight.
    pub seven_bits: bool,
    /// Parity bit: none, even or odd.
    pub parity: LineParity,
    /// Two stop bits instead of one.
    pub two_stop_bits: bool,
}

/// Parity of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineParity {
    /// `N`
    None,
    /// `E`
    Even,
    /// `O`
    Odd,
}

impl Framing {
    /// 8N1, as nearly everything.
    pub const PLAIN: Self = Self { seven_bits: false, parity: LineParity::None, two_stop_bits: false };

    /// Every framing with its usual name.
    pub const NAMES: [(&'static str, Self); 8] = {
        const fn of(seven_bits: bool, parity: LineParity, two_stop_bits: bool) -> Framing {
            Framing { seven_bits, parity, two_stop_bits }
        }
        [
            ("8N1", of(false, LineParity::None, false)),
            ("8N2", of(false, LineParity::None, true)),
            ("8E1", of(false, LineParity::Even, false)),
            ("8O1", of(false, LineParity::Odd, false)),
            ("7E1", of(true, LineParity::Even, false)),
            ("7O1", of(true, LineParity::Odd, false)),
            ("7E2", of(true, LineParity::Even, true)),
            ("7O2", of(true, LineParity::Odd, true)),
        ]
    };

    /// Reads the key `framing`, if present.
    pub fn read(table: &Table<'_>) -> Option<Self> {
        let text = table.optional_one_of("framing", &Self::NAMES.map(|(name, _)| name))?;
        Self::NAMES.iter().find(|(name, _)| *name == text).map(|(_, framing)| *framing)
    }
}

impl fmt::Display for Framing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, framing)| framing == self).map_or("8N1", |(name, _)| name);
        f.write_str(name)
    }
}

/// An open port.
pub struct Port {
    stream: SerialStream,
    name: String,
    baud: u32,
    framing: Framing,
    /// Bytes read since the last that meant something.
    senseless_bytes: u64,
    /// The last request was not answered: its answer may still come.
    owing: bool,
}

/// Opens a port for a session and logs a line speed that was refused, or an adapter that is slow.
///
/// # Errors
/// `Absent` or `Refused`.
pub fn open(name: &str, baud: u32, framing: Framing, link: &mut Link) -> Result<Port, SessionEnd> {
    let (port, remark) = open_remarked(name, baud, framing)?;
    if let Some(remark) = remark {
        link.log(true, remark);
    }
    Ok(port)
}

/// Opens a port; the text reports a line speed that was refused, or an adapter that is slow.
///
/// # Errors
/// `Absent` or `Refused`.
pub fn open_remarked(name: &str, baud: u32, framing: Framing) -> Result<(Port, Option<String>), SessionEnd> {
    if !Path::new(name).exists() {
        return Err(trouble::absent(name));
    }
    let (stream, remark) = match open_at(name, baud, framing) {
        Ok(stream) => (stream, None),
        Err(first) => match open_at(name, PLAIN_BAUD, framing) {
            Ok(stream) => {
                (stream, Some(format!("{name} takes no {baud} baud ({first}); opened at {PLAIN_BAUD}")))
            }
            Err(_) => return Err(trouble::refusal(name, &first)),
        },
    };
    let remark = remark.or_else(|| trouble::slow_adapter(name));
    Ok((Port { stream, name: name.into(), baud, framing, senseless_bytes: 0, owing: false }, remark))
}

fn open_at(name: &str, baud: u32, framing: Framing) -> tokio_serial::Result<SerialStream> {
    tokio_serial::new(name, baud)
        .data_bits(if framing.seven_bits { DataBits::Seven } else { DataBits::Eight })
        .parity(match framing.parity {
            LineParity::None => Parity::None,
            LineParity::Even => Parity::Even,
            LineParity::Odd => Parity::Odd,
        })
        .stop_bits(if framing.two_stop_bits { StopBits::Two } else { StopBits::One })
        .open_native_async()
}

impl Port {
    /// Name as opened.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reads what is there, waiting at most `limit`; `None` when nothing came. Cancel safe.
    pub async fn read(&mut self, buffer: &mut [u8], limit: Duration) -> Result<Option<usize>, SessionEnd> {
        match timeout(limit, self.stream.read(buffer)).await {
            Err(_) => Ok(None),
            Ok(Ok(0)) => Err(SessionEnd::Disconnected(format!("{} hung up", self.name))),
            Ok(Ok(count)) => {
                self.senseless_bytes += count as u64;
                Ok(Some(count))
            }
            Ok(Err(error)) => Err(SessionEnd::Disconnected(format!("reading {}: {error}", self.name))),
        }
    }

    /// A line that is open already.
    #[cfg(test)]
    pub(super) fn over(stream: SerialStream) -> Self {
        Self {
            stream,
            name: "line".into(),
            baud: PLAIN_BAUD,
            framing: Framing::PLAIN,
            senseless_bytes: 0,
            owing: false,
        }
    }

    /// Whether the last request was not answered; it is forgotten with the question.
    pub(super) fn take_owing(&mut self) -> bool {
        std::mem::take(&mut self.owing)
    }

    /// Keeps that the last request was not answered.
    pub(super) fn set_owing(&mut self, owing: bool) {
        self.owing = owing;
    }

    /// What was read so far was what it should be.
    pub fn makes_sense(&mut self) {
        self.senseless_bytes = 0;
    }

    /// Writes all bytes. Dropped midway, some may have been written.
    pub async fn write(&mut self, bytes: &[u8]) -> Result<(), SessionEnd> {
        match timeout(WRITE_LIMIT, self.stream.write_all(bytes)).await {
            Err(_) => {
                Err(SessionEnd::Silent { who: format!("{} takes no bytes", self.name), waited: WRITE_LIMIT })
            }
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => Err(SessionEnd::Disconnected(format!("writing to {}: {error}", self.name))),
        }
    }

    /// The end of a session in which nothing right came back: silence, or bytes that mean nothing at this speed.
    pub fn no_answer(&self, asked: &str, waited: Duration) -> SessionEnd {
        let Self { name, baud, framing, senseless_bytes, .. } = self;
        let remedy = if *senseless_bytes == 0 {
            "check that it is switched on, its cable, and that this is its port".into()
        } else {
            format!(
                "{senseless_bytes} bytes came that make no sense at {baud} baud {framing}: make `baud` that of the device; \
                 `trunnion devices --port {name}` tries others"
            )
        };
        SessionEnd::Silent { who: format!("{name} does not answer {asked}; {remedy}"), waited }
    }
}
