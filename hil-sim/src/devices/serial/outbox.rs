//! Answers that leave a device some time after the question.

use std::collections::VecDeque;

/// Answers under way, in the order they will be sent.
#[derive(Debug, Clone, Default)]
pub struct Outbox {
    waiting: VecDeque<(f64, Vec<u8>)>,
}

impl Outbox {
    /// Sends `bytes` at `due_s`, or behind what is already waiting.
    pub fn put(&mut self, due_s: f64, bytes: Vec<u8>) {
        let due_s = self.waiting.back().map_or(due_s, |(last_s, _)| due_s.max(*last_s));
        self.waiting.push_back((due_s, bytes));
    }

    /// When the next answer leaves.
    pub fn next_due_s(&self) -> Option<f64> {
        self.waiting.front().map(|(due_s, _)| *due_s)
    }

    /// What leaves up to `now_s`.
    pub fn take_due(&mut self, now_s: f64) -> Vec<u8> {
        let mut bytes = Vec::new();
        while self.next_due_s().is_some_and(|due_s| due_s <= now_s) {
            bytes.extend(self.waiting.pop_front().map(|(_, answer)| answer).unwrap_or_default());
        }
        bytes
    }

    /// Forgets everything: the power was off.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }
}
