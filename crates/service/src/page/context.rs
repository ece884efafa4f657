//! What the calls share: the page behind them, and the answers that several give.

use super::access::Access;
use super::answer::{Refusal, json_of};
use super::runs::Runs;
use super::shared::Shared;
use axum::extract::rejection::JsonRejection;
use axum::http::StatusCode;
use axum::response::Response;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use trunnion::page::label;
use trunnion::results::{PageFormat, PageStatus, Published, Serves, ServiceStatus};

/// What the calls share.
#[derive(Clone)]
pub(super) struct Page {
    pub(super) shared: Arc<Shared>,
    pub(super) runs: Arc<Runs>,
    pub(super) access: Access,
    pub(super) watchers: Arc<Semaphore>,
    /// One report is printed at a time.
    pub(super) printer: Arc<Semaphore>,
    /// The page of a filed report and its PDF change together.
    pub(super) filing: Arc<Mutex<()>>,
    pub(super) cancel: CancellationToken,
}

pub(super) type Answer = Result<Response, Refusal>;

/// What the page shows before anything is asked.
pub(super) fn status_of(page: &Page) -> Answer {
    let shared = &page.shared;
    let value = |text: String| serde_json::from_str::<Value>(&text).unwrap_or_default();
    let mut topics: BTreeMap<String, Value> =
        shared.board.now().into_iter().map(|(topic, text)| (topic, value(text))).collect();
    // The topic is a second old; who chose sees the choice.
    if let Some(Value::Object(status)) = topics.get_mut(ServiceStatus::TOPIC) {
        status.insert("chosen".into(), shared.board.operator().peek_chosen().into());
    }
    json_of(&PageStatus {
        format: PageFormat::V1,
        program: label(),
        serves: shared.serves,
        name: shared.name.clone(),
        cycles: shared.cycles.clone(),
        operates: shared.serves == Serves::Service,
        topics,
    })
}

/// A body that is not what the call takes.
pub(super) fn wrong(rejection: JsonRejection) -> Refusal {
    match rejection.status() {
        StatusCode::PAYLOAD_TOO_LARGE => Refusal::Wrong("the body is larger than any call needs".into()),
        _ => Refusal::Wrong(rejection.body_text()),
    }
}

/// Longest name in a ladder or a report.
const LONGEST_NAME: usize = 60;

/// The name of a person, as a file keeps it.
pub(super) fn person(name: &str, question: &str) -> Result<String, Refusal> {
    let name = name.trim();
    let fits =
        !name.is_empty() && name.chars().count() <= LONGEST_NAME && !name.chars().any(char::is_control);
    let refused = || Refusal::Wrong(format!("{question} a name of at most {LONGEST_NAME} characters"));
    fits.then(|| name.to_owned()).ok_or_else(refused)
}
