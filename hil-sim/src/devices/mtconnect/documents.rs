//! Documents on their way out of the agent, one of which may be disturbed.

use crate::devices::ReplyFault;
use hyper::body::{Body, Bytes, Frame, SizeHint};
use std::collections::VecDeque;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::sync::mpsc;

/// Counts documents.
pub(super) struct Documents {
    fault: Option<(u64, ReplyFault)>,
    count: AtomicU64,
}

impl Documents {
    pub fn new(fault: Option<(u64, ReplyFault)>) -> Self {
        Self { fault, count: AtomicU64::new(0) }
    }

    /// What happens to the next one.
    fn next(&self) -> Option<ReplyFault> {
        let number = self.count.fetch_add(1, Ordering::Relaxed);
        self.fault.filter(|(at, _)| *at == number).map(|(_, fault)| fault)
    }

    /// The body of an answer; `next` is what would be asked for after it. An error closes the connection.
    pub async fn answer(&self, whole: Bytes, next: impl FnOnce() -> Bytes) -> io::Result<AnswerBody> {
        let frames = match self.next() {
            None => [whole].into(),
            Some(ReplyFault::Late(by_s)) => {
                tokio::time::sleep(Duration::from_secs_f64(by_s)).await;
                [whole].into()
            }
            Some(ReplyFault::Doubled) => [whole.clone(), whole].into(),
            Some(ReplyFault::Merged) => [whole, next()].into(),
            Some(ReplyFault::Dropped) => return Err(closed()),
            Some(ReplyFault::Cut) => {
                let bytes = whole.len() as u64;
                return Ok(AnswerBody::Cut { half: Some(whole.slice(..whole.len() / 2)), bytes });
            }
        };
        Ok(AnswerBody::Whole(frames))
    }
}

/// Parts of one stream.
pub(super) struct Parts {
    queue: mpsc::Sender<io::Result<Bytes>>,
    /// One that leaves together with the next.
    held: Vec<u8>,
}

impl Parts {
    pub fn new(queue: mpsc::Sender<io::Result<Bytes>>) -> Self {
        Self { queue, held: Vec::new() }
    }

    /// Sends a part; `None` when there is no connection any more.
    pub async fn send(&mut self, part: Bytes, documents: &Documents) -> Option<()> {
        match documents.next() {
            None => {}
            Some(ReplyFault::Late(by_s)) => tokio::time::sleep(Duration::from_secs_f64(by_s)).await,
            Some(ReplyFault::Doubled) => self.queue.send(Ok(part.clone())).await.ok()?,
            Some(ReplyFault::Merged) => {
                self.held = part.to_vec();
                return Some(());
            }
            Some(fault @ (ReplyFault::Dropped | ReplyFault::Cut)) => {
                if fault == ReplyFault::Cut {
                    self.queue.send(Ok(part.slice(..part.len() / 2))).await.ok()?;
                }
                self.queue.send(Err(closed())).await.ok()?;
                return None;
            }
        }
        let together = [std::mem::take(&mut self.held), part.to_vec()].concat();
        self.queue.send(Ok(together.into())).await.ok()
    }

    /// When the reader has gone.
    pub async fn closed(&self) {
        self.queue.closed().await;
    }
}

fn closed() -> io::Error {
    io::ErrorKind::ConnectionReset.into()
}

/// Whole documents, half of one, or a stream of parts. An error closes the connection.
pub(super) enum AnswerBody {
    Whole(VecDeque<Bytes>),
    /// So many bytes are promised.
    Cut {
        half: Option<Bytes>,
        bytes: u64,
    },
    Stream(mpsc::Receiver<io::Result<Bytes>>),
}

impl Body for AnswerBody {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<io::Result<Frame<Bytes>>>> {
        match self.get_mut() {
            Self::Whole(frames) => Poll::Ready(frames.pop_front().map(|frame| Ok(Frame::data(frame)))),
            Self::Cut { half, .. } => Poll::Ready(Some(half.take().map(Frame::data).ok_or_else(closed))),
            Self::Stream(parts) => {
                parts.poll_recv(context).map(|part| part.map(|part| part.map(Frame::data)))
            }
        }
    }

    fn size_hint(&self) -> SizeHint {
        match self {
            Self::Whole(frames) => SizeHint::with_exact(frames.iter().map(|frame| frame.len() as u64).sum()),
            Self::Cut { bytes, .. } => SizeHint::with_exact(*bytes),
            Self::Stream(_) => SizeHint::default(),
        }
    }
}
