//! Devices that speak only when they are asked: one request, one answer, and the moments of both.

use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::serial::Port;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_core::HostTime;

/// A device that talks without being asked is not waited for to fall silent.
const MOST_STALE_READS: usize = 16;
/// Bytes of one answer follow each other within this; a pause so long is the end of a late one.
const QUIET: Duration = Duration::from_millis(50);

/// What became of a request.
#[derive(Debug)]
pub struct Exchange<T> {
    /// When the request had been handed to the port.
    pub sent: HostTime,
    /// When the first byte of the answer was there; that of `arrival` when nothing came.
    pub begun: HostTime,
    /// When the answer was whole, or was given up.
    pub arrival: HostTime,
    /// The answer; `None` when none came in time.
    pub answer: Option<T>,
}

impl<T> Exchange<T> {
    /// The middle between request and beginning of the answer: what was read, was read between the two.
    pub fn middle(&self) -> HostTime {
        HostTime(self.sent.0 + (self.begun.0 - self.sent.0) / 2)
    }
}

/// A decoder of answers.
pub trait Decode<T> {
    /// Takes bytes as they come and gives the answer when it is whole.
    fn push(&mut self, bytes: &[u8]) -> Option<T>;
    /// Forgets half an answer.
    fn restart(&mut self);
}

/// Sends a request and waits for its answer. What was still on its way from before the request is decoded and counted, and neither
/// taken for the answer nor for its beginning. After a request without answer the late one is waited for as long as for an answer: it
/// would pass for that of the next. Not cancel safe: a request may have been sent.
pub async fn exchange<T>(
    port: &mut Port,
    link: &Link,
    request: &[u8],
    limit: Duration,
    decoder: &mut impl Decode<T>,
) -> Result<Exchange<T>, SessionEnd> {
    let mut buffer = [0; 1024];
    let mut wait = if port.take_owing() { limit } else { Duration::ZERO };
    for _ in 0..MOST_STALE_READS {
        let Some(count) = port.read(&mut buffer, wait).await? else { break };
        wait = wait.min(QUIET);
        decoder.push(&buffer[..count]);
    }
    decoder.restart();
    port.write(request).await?;
    let sent = link.now();
    let deadline = Instant::now() + limit;
    let mut begun = None;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        let count = port.read(&mut buffer, left).await?;
        let arrival = link.now();
        let begun = *begun.get_or_insert(arrival);
        let answer = count.and_then(|count| decoder.push(&buffer[..count]));
        if answer.is_some() || Instant::now() >= deadline {
            port.set_owing(answer.is_none());
            return Ok(Exchange { sent, begun, arrival, answer });
        }
    }
}
