//! Devices that speak only when they are asked: one request, one answer, and the moments of both.

use crate::link::Link;
use crate::session_end::SessionEnd;
use crate::transport::serial::Port;
use std::time::Duration;
use tokio::time::Instant;
use trunnion_core::HostTime;

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
    /// An answer has begun and not ended.
    fn is_half(&self) -> bool;
    /// Forgets half an answer: what comes next is another.
    fn restart(&mut self);
    /// Half an answer means nothing, however it goes on.
    fn spoil(&mut self);
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
    take_stale(port, limit, decoder, &mut buffer).await?;
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

/// Decodes what is of before, until the line is quiet. Any answer is whole within `limit`, and so is one that comes twice within twice that:
/// a device that goes on talking after it does so without being asked, and is not waited for to fall silent.
async fn take_stale<T>(
    port: &mut Port,
    limit: Duration,
    decoder: &mut impl Decode<T>,
    buffer: &mut [u8],
) -> Result<(), SessionEnd> {
    let mut wait = if port.take_owing() { limit } else { Duration::ZERO };
    let deadline = Instant::now() + 2 * limit;
    while Instant::now() < deadline {
        let wait_now = if decoder.is_half() { wait.max(QUIET) } else { wait };
        let Some(count) = port.read(buffer, wait_now).await? else {
            // Half an answer that was broken off: its rest does not come any more.
            decoder.restart();
            return Ok(());
        };
        wait = wait.min(QUIET);
        decoder.push(&buffer[..count]);
    }
    decoder.spoil();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio_serial::SerialStream;
    use trunnion_protocol::lines::Lines;

    /// Long: what is shown does not depend on the speed of the computer.
    const LIMIT: Duration = Duration::from_secs(1);
    /// At 9600 baud.
    const BYTE: Duration = Duration::from_millis(1);
    const ANSWER: &str = "+099.0000";

    impl Decode<String> for Lines {
        fn push(&mut self, bytes: &[u8]) -> Option<String> {
            bytes.iter().filter_map(|byte| self.push(*byte, |line| Some(line.to_owned()))).last()
        }

        fn is_half(&self) -> bool {
            Self::is_half(self)
        }

        fn restart(&mut self) {
            Self::restart(self);
        }

        fn spoil(&mut self) {
            Self::spoil(self);
        }
    }

    /// The answer of a device that says this without being asked, byte by byte, and answers what it is asked behind it.
    async fn answer(stale: String, is_owing: bool) -> Option<String> {
        let (mut device, line) = SerialStream::pair().unwrap();
        // Of a second line, where there is one: what comes as a whole after the request is an answer.
        let part = stale.len().min(12);
        let (sent, mut is_sent) = tokio::sync::watch::channel(0);
        let device = tokio::spawn(async move {
            let mut ticks = tokio::time::interval(BYTE);
            let mut request = [0; 8];
            let mut stale = stale.as_bytes().chunks(1);
            let mut is_asked = false;
            loop {
                tokio::select! {
                    asked = device.read(&mut request) => is_asked |= asked.is_ok(),
                    _ = ticks.tick() => match stale.next() {
                        Some(byte) => {
                            device.write_all(byte).await.unwrap();
                            sent.send_modify(|bytes| *bytes += 1);
                        }
                        None if std::mem::take(&mut is_asked) => {
                            device.write_all(format!("{ANSWER}\r").as_bytes()).await.unwrap();
                        }
                        None => {}
                    },
                }
            }
        });
        let mut port = Port::over(line);
        port.set_owing(is_owing);
        let link = probe::link(LIMIT);
        // A part of it is there.
        tokio::time::timeout(10 * LIMIT, is_sent.wait_for(|bytes| *bytes >= part)).await.unwrap().unwrap();
        let exchange = exchange(&mut port, &link, b"R", LIMIT, &mut Lines::default()).await.unwrap();
        device.abort();
        exchange.answer
    }

    #[tokio::test]
    async fn the_rest_of_an_answer_of_before_is_no_answer() {
        for is_owing in [true, false] {
            let doubled = "+012.3456\r+012.3456\r".to_owned();
            assert_eq!(answer(doubled, is_owing).await.as_deref(), Some(ANSWER));
            // Broken off.
            assert_eq!(answer("+012.3".to_owned(), is_owing).await.as_deref(), Some(ANSWER));
        }
        // A device that talks for longer than is waited for it: whole lines alone are values.
        let line = "+012.3456".to_owned();
        let answer = answer([line.as_str(); 350].join("\r"), false).await.unwrap();
        assert!(answer == line || answer == ANSWER, "{answer}");
    }
}
