//! How far the cycle is.

use std::io::{IsTerminal, Write};
use trunnion_sync::Progress;

/// One line on standard error: share done and time left.
pub(super) struct ProgressBar {
    shown: bool,
    quiet: bool,
}

impl ProgressBar {
    pub(super) fn new(quiet: bool) -> Self {
        Self { shown: false, quiet: quiet || !std::io::stderr().is_terminal() }
    }

    pub(super) fn show(&mut self, progress: Progress) {
        const WIDTH: usize = 40;
        let total = progress.total.max(1);
        if self.quiet || !(progress.done.is_multiple_of(7) || progress.done == total) {
            return;
        }
        let full = (WIDTH * progress.done / total).min(WIDTH);
        let left = progress.seconds_left.map_or(String::new(), |s| format!(", {s:.0} s left"));
        eprint!("\r  [{}{}] {}/{total}{left}   ", "#".repeat(full), ".".repeat(WIDTH - full), progress.done);
        self.shown = std::io::stderr().flush().is_ok();
    }

    pub(super) fn clear(&mut self) {
        if self.shown {
            eprint!("\r{:80}\r", "");
        }
    }
}
