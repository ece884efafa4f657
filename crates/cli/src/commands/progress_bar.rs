//! How far the cycle is.

use std::io::{IsTerminal, Write};
use trunnion_service::live::Progress;

/// One line on standard error: share done and time left.
pub struct ProgressBar {
    shown: bool,
    quiet: bool,
}

impl ProgressBar {
    pub fn new(quiet: bool) -> Self {
        Self { shown: false, quiet: quiet || !std::io::stderr().is_terminal() }
    }

    pub fn show(&mut self, progress: Progress) {
        const WIDTH: usize = 40;
        let total = progress.total.max(1);
        if self.quiet || !(progress.done.is_multiple_of(7) || progress.done == total) {
            return;
        }
        let full = (WIDTH * progress.done / total).min(WIDTH);
        let left = progress.seconds_left.map_or(String::new(), |s| format!(", {s:.0} s left"));
        let (bar, rest) = ("#".repeat(full), ".".repeat(WIDTH - full));
        let mut out = std::io::stderr().lock();
        let written = write!(out, "\r  [{bar}{rest}] {}/{total}{left}   ", progress.done);
        self.shown = written.and_then(|()| out.flush()).is_ok();
    }

    pub fn clear(&mut self) {
        if self.shown {
            write!(std::io::stderr(), "\r{:80}\r", "").ok();
        }
    }
}
