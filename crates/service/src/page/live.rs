//! What changes, as server-sent events: each is the value of one topic.

use crate::board::Board;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, watch};
use tokio_util::sync::CancellationToken;

/// Browsers that watch at once.
pub const MOST_WATCHERS: usize = 16;
/// Shortest time between two events of a topic: eyes see no more, and a browser that is slow gets the latest value.
const SHORTEST: Duration = Duration::from_millis(50);

/// Places for those who watch.
pub fn places() -> Arc<Semaphore> {
    Arc::new(Semaphore::new(MOST_WATCHERS))
}

struct Watching {
    board: Board,
    changes: watch::Receiver<u64>,
    sent: BTreeMap<String, String>,
    waiting: VecDeque<(String, String)>,
    cancel: CancellationToken,
    _place: OwnedSemaphorePermit,
}

/// The present value of every topic, then each change; several changes at once are one.
pub fn events(board: &Board, cancel: CancellationToken, place: OwnedSemaphorePermit) -> Response {
    let mut changes = board.changes();
    changes.mark_changed();
    let watching = Watching {
        board: board.clone(),
        changes,
        sent: BTreeMap::new(),
        waiting: VecDeque::new(),
        cancel,
        _place: place,
    };
    Sse::new(stream::unfold(watching, next)).keep_alive(KeepAlive::default()).into_response()
}

async fn next(mut watching: Watching) -> Option<(Result<Event, Infallible>, Watching)> {
    loop {
        if let Some((topic, value)) = watching.waiting.pop_front() {
            return Some((Ok(Event::default().event(topic).data(value)), watching));
        }
        let cancel = watching.cancel.clone();
        tokio::select! {
            () = cancel.cancelled() => return None,
            changed = watching.changes.changed() => changed.ok()?,
        }
        if !watching.sent.is_empty() {
            tokio::time::sleep(SHORTEST).await;
        }
        watching.changes.mark_unchanged();
        let now = watching.board.now();
        let is_new = |(topic, value): &(&String, &String)| watching.sent.get(*topic) != Some(*value);
        watching.waiting =
            now.iter().filter(is_new).map(|(topic, value)| (topic.clone(), value.clone())).collect();
        watching.sent = now;
    }
}
