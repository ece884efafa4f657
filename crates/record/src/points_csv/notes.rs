//! Problems of a points file, listed up to a limit and counted beyond it.

use trunnion_core::Problem;

/// Problems kept of a file that is wrong everywhere; the same one in many rows is printed once with its count, so only the
/// memory of this list is a reason for a limit (some 30 MB).
const MOST_PROBLEMS: usize = 100_000;

/// Problems found so far.
pub(super) struct Notes<'a> {
    file: &'a str,
    list: Vec<Problem>,
    more: usize,
}

impl<'a> Notes<'a> {
    pub fn of(file: &'a str) -> Self {
        Self { file, list: Vec::new(), more: 0 }
    }

    pub fn add(&mut self, line: usize, column: usize, found: &str, allowed: &str, advice: &str) {
        if self.list.len() >= MOST_PROBLEMS {
            self.more += 1;
            return;
        }
        let (found, allowed, advice) = (found.into(), allowed.into(), advice.into());
        self.list.push(Problem { file: self.file.into(), line, column, found, allowed, advice });
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub fn count(&self) -> usize {
        self.list.len() + self.more
    }

    pub fn finish(mut self) -> Vec<Problem> {
        if self.more > 0 {
            self.list.push(Problem {
                file: self.file.into(),
                line: 0,
                column: 0,
                found: format!("{} more problems of this file are not listed", self.more),
                allowed: String::new(),
                advice: String::new(),
            });
        }
        self.list
    }
}
