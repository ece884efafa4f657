//! How far the cycle is.

use std::io::{IsTerminal, Write};
use trunnion_service::live::Progress;

/// Columns of the line; a terminal has 80.
const LINE: usize = 79;

/// One line on standard error: share done, and time left or what is under way.
pub struct ProgressBar {
    shown: bool,
    quiet: bool,
}

impl ProgressBar {
    pub fn new(quiet: bool) -> Self {
        Self { shown: false, quiet: quiet || !std::io::stderr().is_terminal() }
    }

    /// Of a cycle, whose poses follow each other fast.
    pub fn show(&mut self, progress: Progress) {
        if progress.done.is_multiple_of(7) || progress.done == progress.total {
            let left = progress.seconds_left.map_or(String::new(), |s| format!("{s:.0} s left"));
            self.show_of(&left, progress.done, progress.total);
        }
    }

    /// Of anything, with a word about it.
    pub fn show_of(&mut self, word: &str, done: usize, total: usize) {
        const WIDTH: usize = 40;
        if self.quiet {
            return;
        }
        let total = total.max(1);
        let full = (WIDTH * done / total).min(WIDTH);
        let word = if word.is_empty() { String::new() } else { format!(", {word}") };
        let (bar, rest) = ("#".repeat(full), ".".repeat(WIDTH - full));
        let mut line = format!("  [{bar}{rest}] {done}/{total}{word}");
        // One that is wrapped is not written over.
        line.truncate(line.char_indices().nth(LINE).map_or(line.len(), |(end, _)| end));
        let mut out = std::io::stderr().lock();
        let written = write!(out, "\r{line:LINE$}");
        self.shown = written.and_then(|()| out.flush()).is_ok();
    }

    pub fn clear(&mut self) {
        if self.shown {
            write!(std::io::stderr(), "\r{:LINE$}\r", "").ok();
        }
    }
}
