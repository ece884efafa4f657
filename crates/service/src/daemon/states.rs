//! Where the service is with its cycles: the topic `cycle`, and the same state in `status`.
//!
//! A cycle is analysed while the next one is measured: what comes of it then stands in `result` alone.

use crate::board::Board;
use std::sync::{Arc, Mutex, PoisonError};
use trunnion::results::{CycleNow, CycleProgress, CycleState};

/// The newest cycle, shared with the tasks that analyse.
#[derive(Clone)]
pub struct States {
    board: Board,
    newest: Arc<Mutex<CycleProgress>>,
}

impl States {
    /// Publishes on this board.
    pub fn new(board: Board) -> Self {
        Self { board, newest: Arc::default() }
    }

    /// A new cycle, or none.
    pub fn begin(&self, state: CycleState, run: &str, now: CycleProgress) {
        let mut newest = self.lock();
        *newest = CycleProgress { run: Some(run.to_owned()).filter(|run| !run.is_empty()), state, ..now };
        self.board.publish(&*newest);
    }

    /// The cycle of this run goes on; nothing when a newer one has begun.
    pub fn go_on(&self, state: CycleState, run: &str, now: CycleProgress) {
        let mut newest = self.lock();
        if newest.run.as_deref().unwrap_or_default() == run {
            *newest = std::mem::take(&mut *newest).updated(CycleProgress { state, ..now });
            self.board.publish(&*newest);
        }
    }

    /// The cycle of this run is a part of one that was joined, which is analysed in its place: what was read and is missing is not known yet.
    pub fn joined(&self, part: &str, run: &str, recording: Option<String>) {
        let mut newest = self.lock();
        if newest.run.as_deref().unwrap_or_default() == part {
            let run = Some(run.to_owned());
            let (read, unsettled, missing, gaps) = (None, None, None, None);
            *newest = CycleProgress {
                run,
                recording,
                read,
                unsettled,
                missing,
                gaps,
                ..std::mem::take(&mut *newest)
            };
            self.board.publish(&*newest);
        }
    }

    /// For `status`.
    pub fn now(&self) -> CycleNow {
        let newest = self.lock();
        CycleNow { state: newest.state, run: newest.run.clone() }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, CycleProgress> {
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
        states.begin(
            CycleState::Measuring,
            "a",
            CycleProgress { cycle: Some("low".into()), ..CycleProgress::default() },
        );
        states.go_on(
            CycleState::Analysing,
            "a",
            CycleProgress { read: Some(10), ..CycleProgress::default() },
        );
        assert_eq!(
            board.get("cycle").unwrap(),
            json!({ "state": "analysing", "run": "a", "cycle": "low", "read": 10, "seconds_left": null })
        );
        states.begin(
            CycleState::Measuring,
            "b",
            CycleProgress { cycle: Some("high".into()), ..CycleProgress::default() },
        );
        states.go_on(CycleState::Done, "a", CycleProgress::default());
        let newer = json!({ "state": "measuring", "run": "b", "cycle": "high", "seconds_left": null });
        assert_eq!(board.get("cycle").unwrap(), newer);
        assert_eq!(states.now(), CycleNow { state: CycleState::Measuring, run: Some("b".into()) });
    }

    #[test]
    fn a_cycle_whose_part_was_joined_goes_on_under_the_name_of_the_whole() {
        let (board, now) = (Board::default(), CycleProgress::default());
        let states = States::new(board.clone());
        states.begin(CycleState::Measuring, "b", now.clone());
        let recording = |name: &str| Some(format!("{name}.mcap"));
        let read = CycleProgress { recording: recording("b"), read: Some(10), ..now.clone() };
        states.go_on(CycleState::Analysing, "b", read);
        states.joined("a", "z-joined", recording("z-joined"));
        assert_eq!(states.now().run.as_deref(), Some("b"), "of another cycle");
        states.joined("b", "a-joined", recording("a-joined"));
        states.go_on(CycleState::Done, "a-joined", now);
        let whole =
            json!({ "state": "done", "run": "a-joined", "recording": "a-joined.mcap", "seconds_left": null });
        assert_eq!(board.get("cycle").unwrap(), whole);
    }

    #[test]
    fn a_time_left_that_is_not_known_any_more_is_null() {
        let (board, now) = (Board::default(), CycleProgress::default());
        let states = States::new(board.clone());
        states.begin(CycleState::Measuring, "a", now.clone());
        let known = CycleProgress { done: Some(3), seconds_left: Some(9.0), ..now.clone() };
        states.go_on(CycleState::Measuring, "a", known);
        assert_eq!(board.get("cycle").unwrap()["seconds_left"], 9.0);
        states.go_on(CycleState::Measuring, "a", CycleProgress { done: Some(4), ..now });
        let unknown = json!({ "state": "measuring", "run": "a", "done": 4, "seconds_left": null });
        assert_eq!(board.get("cycle").unwrap(), unknown);
    }
}
