//! How long a busy computer lets a program wait: without this, what depends on time cannot be judged.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

const SLEEP: Duration = Duration::from_millis(2);
/// Shorter pauses are not kept with their time: half of the shortest hole that the test of host faults looks for, ten steps of probes
/// that measure every millisecond (`tests/end_to_end/host_faults/losses.rs`).
const KEPT: Duration = Duration::from_millis(5);

/// Measures, from its start until it is dropped, how much later than asked a thread goes on, and in an asynchronous runtime a task:
/// a runtime whose thread waits for the kernel stands still while other threads go on. Reading a terminal does so on a busy computer,
/// as its bytes are handed over by a worker of the kernel.
pub struct Pauses {
    longest_ns: Arc<AtomicU64>,
    kept: Arc<Mutex<Kept>>,
    stop: Arc<AtomicBool>,
}

#[derive(Default)]
struct Kept {
    /// Those that have ended.
    ended: Vec<Pause>,
    /// When each watch went on last.
    awake: Vec<Instant>,
}

struct Pause {
    begun: Instant,
    ended: Instant,
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
        let watch = {
            let awake = &mut lock(&kept).awake;
            awake.push(Instant::now());
            awake.len() - 1
        };
        move |begun| {
            let ended = Instant::now();
            let length = (ended - *begun).saturating_sub(SLEEP);
            longest.fetch_max(length.as_nanos() as u64, Ordering::Relaxed);
            let mut kept = lock(&kept);
            if length >= KEPT {
                kept.ended.push(Pause { begun: ended - length, ended });
            }
            kept.awake[watch] = ended;
            *begun = ended;
            !stop.load(Ordering::Relaxed)
        }
    }

    /// The longest pause so far.
    pub fn longest(&self) -> Duration {
        Duration::from_nanos(self.longest_ns.load(Ordering::Relaxed))
    }

    /// What of the longest was between two moments; one that is under way counts.
    pub fn longest_between(&self, from: Instant, to: Instant) -> Duration {
        let (kept, now) = (lock(&self.kept), Instant::now());
        let of = |pause: &Pause| pause.ended.min(to).saturating_duration_since(pause.begun.max(from));
        let under_way = kept.awake.iter().map(|awake| of(&Pause { begun: *awake + SLEEP, ended: now }));
        kept.ended.iter().map(of).chain(under_way).max().unwrap_or_default()
    }
}

fn lock(kept: &Mutex<Kept>) -> MutexGuard<'_, Kept> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Drop for Pauses {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_counts_where_it_was_and_one_under_way_does_too() {
        let now = Instant::now();
        let at = |ms: u64| now + Duration::from_millis(ms);
        let pauses = Pauses { longest_ns: Arc::default(), kept: Arc::default(), stop: Arc::default() };
        lock(&pauses.kept).ended.push(Pause { begun: at(100), ended: at(200) });
        let between = |from_ms: u64, to_ms: u64| pauses.longest_between(at(from_ms), at(to_ms)).as_millis();
        assert_eq!([between(0, 300), between(150, 300), between(0, 150)], [100, 50, 50]);
        assert_eq!([between(0, 100), between(200, 300), between(120, 130)], [0, 0, 10]);
        let second = Duration::from_secs(1);
        lock(&pauses.kept).awake.push(now - second);
        assert!(pauses.longest_between(now - second, now) >= second - SLEEP);
    }
}
