//! What a plant reads of the service, whatever its protocol: state, health and the newest result, from the topics of the board.

use crate::board::Board;
use serde::de::DeserializeOwned;
use trunnion::results::{Condition, Published, ResultNow, RunResult, ServiceStatus};

/// State and newest result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlantView {
    /// How the service does; that of one which is offline until it has said otherwise.
    pub status: ServiceStatus,
    /// The newest result; `None` before the first, and where the newest run failed.
    pub result: Option<RunResult>,
}

impl PlantView {
    /// As the board has it now.
    pub fn of(board: &Board) -> Self {
        Self {
            status: topic(board, ServiceStatus::TOPIC).unwrap_or_default(),
            result: topic(board, ResultNow::TOPIC),
        }
    }

    /// The worst of the parts in a sentence; empty when all is well.
    pub fn why(&self) -> String {
        let parts = self.status.health.iter().flat_map(|health| &health.parts);
        let ill = parts.filter(|(_, part)| part.state != Condition::Good);
        ill.map(|(name, part)| format!("{name}: {}", part.why)).collect::<Vec<_>>().join("; ")
    }

    /// The newest result in a sentence; empty before the first.
    pub fn found(&self) -> String {
        let Some(result) = &self.result else { return String::new() };
        let verdict = result.verdict.as_str();
        let effects = result.missing_effects.join(", ");
        let words = [verdict, effects.as_str(), result.why.as_str()];
        words.into_iter().filter(|word| !word.is_empty()).collect::<Vec<_>>().join(": ")
    }
}

/// The present value of a topic; `None` without one of this form.
pub(crate) fn topic<T: DeserializeOwned>(board: &Board, name: &str) -> Option<T> {
    serde_json::from_value(board.get(name)?).ok()
}
