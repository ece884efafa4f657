//! Serial ports, 8N1, opened exclusively.
//!
//! A port that hung up reads zero bytes for ever (Linux) or EIO (pty): both are a disconnection. A pseudo-terminal
//! takes only some line speeds and needs none: where a speed is refused the port is opened at 115 200 baud and the
//! refusal is told.

use crate::supervisor::SessionEnd;
use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::timeout;
use tokio_serial::{SerialPortBuilderExt, SerialStream};

/// A write that takes longer means a stuck adapter.
const WRITE_LIMIT: Duration = Duration::from_secs(1);
/// A line speed every port takes.
const PLAIN_BAUD: u32 = 115_200;

/// An open port.
pub struct Port {
    stream: SerialStream,
    name: String,
}

/// Opens a port; the text tells a line speed that was refused.
///
/// # Errors
/// `Absent` or `Refused`.
pub fn open(name: &str, baud: u32) -> Result<(Port, Option<String>), SessionEnd> {
    if !Path::new(name).exists() {
        return Err(SessionEnd::Absent(name.into()));
    }
    let (stream, remark) = match open_at(name, baud) {
        Ok(stream) => (stream, None),
        Err(first) => match open_at(name, PLAIN_BAUD) {
            Ok(stream) => {
                (stream, Some(format!("{name} takes no {baud} baud ({first}); opened at {PLAIN_BAUD}")))
            }
            Err(_) => return Err(refusal(name, &first)),
        },
    };
    Ok((Port { stream, name: name.into() }, remark))
}

fn open_at(name: &str, baud: u32) -> tokio_serial::Result<SerialStream> {
    tokio_serial::new(name, baud).open_native_async()
}

fn refusal(name: &str, error: &tokio_serial::Error) -> SessionEnd {
    let gone = matches!(error.kind, tokio_serial::ErrorKind::Io(ErrorKind::NotFound));
    if gone || !Path::new(name).exists() {
        return SessionEnd::Absent(name.into());
    }
    let advice = match error.kind {
        tokio_serial::ErrorKind::Io(ErrorKind::PermissionDenied) => {
            "; join the group that owns the port (dialout)"
        }
        tokio_serial::ErrorKind::NoDevice => "; another program may be using it",
        _ => "",
    };
    SessionEnd::Refused { address: name.into(), why: format!("{error}{advice}") }
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
            Ok(Ok(count)) => Ok(Some(count)),
            Ok(Err(error)) => Err(SessionEnd::Disconnected(format!("reading {}: {error}", self.name))),
        }
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
}
