//! How long a busy computer lets a program wait: without this, what depends on time cannot be judged.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

const SLEEP: Duration = Duration::from_millis(2);
/// Shorter pauses are not kept with their time: half of the shortest hole that a test looks for between samples.
const KEPT: Duration = Duration::from_millis(5);

/// Measures, from its start until it is dropped, how much later than asked a thread goes on, and in an asynchronous runtime a task:
/// a runtime whose thread waits for the kernel stands still while other threads go on. Reading a terminal does so on a busy computer,
/// as its bytes are handed over by a worker of the kernel.
pub struct Pauses {
    longest_ns: Arc<AtomicU64>,
    kept: Arc<Mutex<Vec<Pause>>>,
    stop: Arc<AtomicBool>,
}

/// A pause that has ended.
struct Pause {
    ended: Instant,
    length: Duration,
}

impl Pauses {
    /// Begins to measure.
    pub fn watch() -> Self {
        let pauses = Self { longest_ns: Arc::default(), kept: Arc::default(), stop: Arc::default() };
        let watched = pauses.watched();
        std::thread::spawn(move || {
            let mut begun = Instant::now();
            while watched(&mut begun) {
                std::thread::sleep(SLEEP);
            }
        });
        if let Ok(runtime) = tokio::runtime::Handle::try_current() {
            let watched = pauses.watched();
            runtime.spawn(async move {
                let mut begun = Instant::now();
                while watched(&mut begun) {
                    tokio::time::sleep(SLEEP).await;
                }
            });
        }
        pauses
    }

    /// Takes the time since the last call, or since `begun`; false at the end.
    fn watched(&self) -> impl Fn(&mut Instant) -> bool + Send + 'static {
        let (longest, kept, stop) =
            (Arc::clone(&self.longest_ns), Arc::clone(&self.kept), Arc::clone(&self.stop));
        move |begun| {
            let ended = Instant::now();
            let length = (ended - *begun).saturating_sub(SLEEP);
            longest.fetch_max(length.as_nanos() as u64, Ordering::Relaxed);
            if length >= KEPT {
                kept.lock().unwrap_or_else(PoisonError::into_inner).push(Pause { ended, length });
            }
            *begun = ended;
            !stop.load(Ordering::Relaxed)
        }
    }

    /// The longest pause so far.
    pub fn longest(&self) -> Duration {
        Duration::from_nanos(self.longest_ns.load(Ordering::Relaxed))
    }

    /// The longest of those that were between two moments, or over one of them.
    pub fn longest_between(&self, from: Instant, to: Instant) -> Duration {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let was_then = |pause: &&Pause| pause.ended >= from && pause.ended - pause.length <= to;
        kept.iter().filter(was_then).map(|pause| pause.length).max().unwrap_or_default()
    }
}

impl Drop for Pauses {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
