//! Answers that leave a device some time after the question.

use crate::devices::ReplyFault;
use std::collections::VecDeque;

/// Answers under way, in the order they will be sent.
#[derive(Debug, Clone, Default)]
pub struct Outbox {
    waiting: VecDeque<(f64, Vec<u8>)>,
    /// What happens to the answer of this number.
    fault: Option<(u64, ReplyFault)>,
    /// Answers put so far.
    count: u64,
    /// An answer that leaves together with the next.
    held: Vec<u8>,
}

impl Outbox {
    /// With something that happens to the answer of a number, counted from 0.
    pub fn with_fault(fault: Option<(u64, ReplyFault)>) -> Self {
        Self { fault, ..Self::default() }
    }

    /// Sends `bytes` at `due_s`, or behind what is already waiting.
    pub fn put(&mut self, due_s: f64, bytes: Vec<u8>) {
        let number = self.count;
        self.count += 1;
        match self.fault.filter(|(at, _)| *at == number).map(|(_, fault)| fault) {
            Some(ReplyFault::Late(by_s)) => self.enqueue(due_s + by_s, bytes),
            Some(ReplyFault::Doubled) => self.enqueue(due_s, bytes.repeat(2)),
            Some(ReplyFault::Dropped) => {}
            Some(ReplyFault::Cut) => self.enqueue(due_s, bytes[..bytes.len() / 2].to_vec()),
            Some(ReplyFault::Merged) => self.held = bytes,
            None => {
                let together = [std::mem::take(&mut self.held), bytes].concat();
                self.enqueue(due_s, together);
            }
        }
    }

    fn enqueue(&mut self, due_s: f64, bytes: Vec<u8>) {
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
        self.held.clear();
    }
}
