//! Where the service is with its cycles: the topic `cycle`, and the same state in `status`.
//!
//! A cycle is analysed while the next one is measured: what comes of it then stands in `result` alone.

use crate::board::Board;
use serde_json::{Map, Value};
use std::sync::{Arc, Mutex, PoisonError};
use trunnion::results::{CycleNow, CycleState};

/// The newest cycle, shared with the tasks that analyse.
#[derive(Clone)]
pub struct States {
    board: Board,
    newest: Arc<Mutex<Newest>>,
}

#[derive(Default)]
struct Newest {
    state: CycleState,
    /// Name of the run; empty without one.
    run: String,
    /// What is published of it, key by key: what was said before stays.
    details: Map<String, Value>,
}

impl States {
    /// Publishes on this board.
    pub fn new(board: Board) -> Self {
        Self { board, newest: Arc::default() }
    }

    /// A new cycle, or none.
    pub fn begin(&self, state: CycleState, run: &str, details: Value) {
        let mut newest = self.lock();
        *newest = Newest { run: run.into(), ..Newest::default() };
        self.publish(&mut newest, state, details);
    }

    /// The cycle of this run goes on; nothing when a newer one has begun.
    pub fn go_on(&self, state: CycleState, run: &str, details: Value) {
        let mut newest = self.lock();
        if newest.run == run {
            self.publish(&mut newest, state, details);
        }
    }

    /// For `status`.
    pub fn now(&self) -> CycleNow {
        let newest = self.lock();
        let run = Some(newest.run.clone()).filter(|run| !run.is_empty());
        CycleNow { state: newest.state, run }
    }

    fn publish(&self, newest: &mut Newest, state: CycleState, details: Value) {
        newest.state = state;
        if let Value::Object(details) = details {
            newest.details.extend(details);
        }
        newest.details.insert("state".into(), state.as_str().into());
        if !newest.run.is_empty() {
            newest.details.insert("run".into(), newest.run.clone().into());
        }
        self.board.set("cycle", &Value::Object(newest.details.clone()));
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Newest> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_comes_of_an_older_cycle_does_not_hide_the_newer_one() {
        let board = Board::default();
        let states = States::new(board.clone());
        states.begin(CycleState::Measuring, "a", json!({ "cycle": "low" }));
        states.go_on(CycleState::Analysing, "a", json!({ "read": 10 }));
        assert_eq!(
            board.get("cycle").unwrap(),
            json!({ "state": "analysing", "run": "a", "cycle": "low", "read": 10 })
        );
        states.begin(CycleState::Measuring, "b", json!({ "cycle": "high" }));
        states.go_on(CycleState::Done, "a", json!({}));
        assert_eq!(board.get("cycle").unwrap(), json!({ "state": "measuring", "run": "b", "cycle": "high" }));
        assert_eq!(states.now(), CycleNow { state: CycleState::Measuring, run: Some("b".into()) });
    }
}
