//! How long a busy computer lets a program wait: without this, what depends on time cannot be judged.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

const SLEEP: Duration = Duration::from_millis(2);

/// Measures, from its start until it is dropped, how much later than asked a thread goes on.
pub struct Pauses {
    longest_ns: Arc<AtomicU64>,
    stop: Arc<AtomicBool>,
}

impl Pauses {
    /// Begins to measure.
    pub fn watch() -> Self {
        let (longest_ns, stop) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (longest, ended) = (Arc::clone(&longest_ns), Arc::clone(&stop));
        std::thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                let begun = Instant::now();
                std::thread::sleep(SLEEP);
                let late = begun.elapsed().saturating_sub(SLEEP);
                longest.fetch_max(late.as_nanos() as u64, Ordering::Relaxed);
            }
        });
        Self { longest_ns, stop }
    }

    /// The longest pause so far.
    pub fn longest(&self) -> Duration {
        Duration::from_nanos(self.longest_ns.load(Ordering::Relaxed))
    }
}

impl Drop for Pauses {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
