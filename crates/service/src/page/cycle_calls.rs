//! The calls that a person makes at the machine: which cycle is next, begin it, end it (docs/use/page.md).

use super::answer::Refusal;
use super::context::{Answer, Page, status_of, wrong};
use crate::operator::Operator;
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::routing::post;
use axum::{Json, Router};
use serde::Deserialize;
use std::time::Duration;
use tokio::time::timeout;
use trunnion::results::{CycleState, Serves};

/// A cycle begins within milliseconds, and after the room on the disk was looked at; an end waits for the message under way.
const SHOWS_WITHIN: Duration = Duration::from_secs(3);

/// Their routes.
pub(super) fn routes() -> Router<Page> {
    Router::new()
        .route("/api/cycle/choose", post(choose))
        .route("/api/cycle/begin", post(begin))
        .route("/api/cycle/abort", post(abort))
}

/// Which cycle; empty: that of the program.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Chosen {
    cycle: String,
}

async fn choose(State(page): State<Page>, body: Result<Json<Chosen>, JsonRejection>) -> Answer {
    page.chooses(&body.map_err(wrong)?.0.cycle)?;
    status_of(&page)
}

async fn begin(State(page): State<Page>, body: Result<Json<Chosen>, JsonRejection>) -> Answer {
    let chosen = body.map_err(wrong)?.0.cycle;
    if page.is_measuring() {
        return Err(Refusal::NotNow("a cycle is being measured; abort it first, or wait for its end"));
    }
    page.chooses(&chosen)?;
    tracing::info!(cycle = chosen, "begun from the page");
    page.asks(Operator::begin).await;
    status_of(&page)
}

async fn abort(State(page): State<Page>) -> Answer {
    if !page.is_measuring() {
        return Err(Refusal::NotNow("no cycle is being measured"));
    }
    tracing::info!("the cycle was aborted from the page");
    page.asks(Operator::abort).await;
    status_of(&page)
}

impl Page {
    fn chooses(&self, cycle: &str) -> Result<(), Refusal> {
        if self.shared.serves != Serves::Service {
            return Err(Refusal::NotNow("nothing waits for a cycle behind this page"));
        }
        let chosen = self.shared.board.operator().choose(cycle);
        chosen.map_err(|refused| Refusal::Wrong(refused.to_string()))
    }

    /// Asks, and waits until it shows in the state of the cycle: the answer is the state after.
    async fn asks(&self, what: fn(&Operator)) {
        let board = &self.shared.board;
        let (before, mut changes) = (board.get("cycle"), board.changes());
        what(board.operator());
        let shows = async { while board.get("cycle") == before && changes.changed().await.is_ok() {} };
        // What takes longer is said by the state of before, and by the topic later.
        drop(timeout(SHOWS_WITHIN, shows).await);
    }

    fn is_measuring(&self) -> bool {
        let cycle = self.shared.board.get("cycle").unwrap_or_default();
        cycle["state"] == CycleState::Measuring.as_str()
    }
}
