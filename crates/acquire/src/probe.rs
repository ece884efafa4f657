//! What answers at an address: each driver may bring a [`Probe`], one line of its registry entry.
//!
//! A probe asks questions that change nothing, waits for every answer with a limit, and closes what it opened. It never
//! stops an output, resets or zeroes anything; a bus is listened to before anything is asked on it. What it asks is shown to the user
//! ([`Probe::asks`]).

use crate::link::{Link, Outlet};
use crate::session_end::SessionEnd;
use crate::status::DeviceStatus;
use crate::transport::serial;
use crate::transport::serial::{Framing, Port};
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use trunnion_core::{Clock, HostTime};

/// A device that has begun to answer and pauses for so long has finished.
const PAUSE: Duration = Duration::from_millis(60);
/// Bytes of an answer that are kept; a device that streams says more.
const MOST_BYTES: usize = 32 * 1024;

/// What kind of address a probe asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Medium {
    /// A serial port, by its path.
    Serial,
    /// A CAN interface of the kernel, by its name.
    Can,
    /// A server on the network, by a URL of this scheme.
    Network(Scheme),
}

/// The beginning of a URL by which a kind of server is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scheme {
    /// What stands before `://`.
    pub name: &'static str,
    /// Where such a server usually listens.
    pub port: u16,
}

/// Probing under way.
pub type Probing<'a> = Pin<Box<dyn Future<Output = Answer> + Send + 'a>>;

/// How a kind of device is found.
#[derive(Clone, Copy)]
pub struct Probe {
    /// Where.
    pub medium: Medium,
    /// What is sent, in words a user understands.
    pub asks: &'static str,
    /// Asks at an address.
    pub run: for<'a> fn(&'a str) -> Probing<'a>,
}

/// What came of asking.
#[derive(Debug)]
pub enum Answer {
    /// A device of this kind.
    Found(Found),
    /// Bytes came that are no answer.
    Senseless {
        /// How many.
        bytes: u64,
    },
    /// Nothing came.
    Nothing,
    /// The address cannot be used, or another device says what it is.
    Trouble(SessionEnd),
}

/// A device that answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// What it says of itself, and how it was reached.
    pub identity: String,
    /// Lines of its `[[device]]` table after name and driver. `{role}` stands where a role is wanted.
    pub keys: Vec<String>,
}

impl Answer {
    /// From the results of one question after the other: the first that found something, or what is worth reporting.
    pub async fn first<'a>(questions: impl IntoIterator<Item = Probing<'a>>) -> Self {
        let mut senseless = 0;
        for question in questions {
            match question.await {
                Self::Nothing => {}
                Self::Senseless { bytes } => senseless += bytes,
                end @ (Self::Found(_) | Self::Trouble(_)) => return end,
            }
        }
        if senseless > 0 { Self::Senseless { bytes: senseless } } else { Self::Nothing }
    }

    /// What bytes that are no answer are.
    pub fn none_in(bytes: &[u8]) -> Self {
        if bytes.is_empty() { Self::Nothing } else { Self::Senseless { bytes: bytes.len() as u64 } }
    }
}

/// A link for drivers that ask as their session does. Nobody takes what is sent over it.
pub fn link(silence: Duration) -> Link {
    let (sender, _) = mpsc::channel(1);
    let (status, _) = watch::channel(DeviceStatus::default());
    let clock = Arc::new(Stopwatch(Instant::now()));
    Link::new(0, Vec::new(), silence, clock, Outlet::new(0, String::new(), sender), status)
}

struct Stopwatch(Instant);

impl Clock for Stopwatch {
    fn now(&self) -> HostTime {
        HostTime(self.0.elapsed().as_nanos() as i64)
    }

    fn wall_ns(&self) -> i64 {
        0
    }
}

/// Opens a port, sends a request (nothing: only listens) and gives what comes back within `limit`.
///
/// # Errors
/// The port cannot be opened or hung up.
pub async fn ask_at(
    name: &str,
    baud: u32,
    framing: Framing,
    request: &[u8],
    limit: Duration,
) -> Result<Vec<u8>, SessionEnd> {
    let (mut port, _remark) = serial::open_remarked(name, baud, framing)?;
    ask(&mut port, request, limit).await
}

/// Sends a request on an open port and gives what comes back within `limit`, at most until it pauses.
///
/// # Errors
/// The port hung up.
pub async fn ask(port: &mut Port, request: &[u8], limit: Duration) -> Result<Vec<u8>, SessionEnd> {
    let mut buffer = [0; 4096];
    if !request.is_empty() {
        port.write(request).await?;
    }
    let deadline = Instant::now() + limit;
    let mut answer = Vec::new();
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let wait = if answer.is_empty() || request.is_empty() { left } else { left.min(PAUSE) };
        match port.read(&mut buffer, wait).await? {
            Some(count) => answer.extend_from_slice(&buffer[..count]),
            None => return Ok(answer),
        }
        if left.is_zero() || answer.len() >= MOST_BYTES {
            return Ok(answer);
        }
    }
}
