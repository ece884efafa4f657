//! What one thread logs, for tests that look into it.

use std::sync::{Arc, LazyLock, Mutex};
use std::time::Duration;
use tracing::Dispatch;
use tracing::level_filters::LevelFilter;
use tracing::subscriber::{DefaultGuard, NoSubscriber};

/// A second subscriber that takes nothing and is never dropped. With one
/// alone, tracing-core 0.1 asks only the thread that comes to a line first
/// whether anyone wants it: a test without a log would silence that line for
/// the test with one.
static SECOND: LazyLock<Dispatch> = LazyLock::new(|| Dispatch::new(NoSubscriber::new()));

/// What was logged, shared with the test.
#[derive(Clone, Default)]
pub struct Log(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().expect("not poisoned").write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Log {
    /// Takes what this thread logs, as long as the guard is there.
    pub fn begin(most: LevelFilter) -> (Self, DefaultGuard) {
        LazyLock::force(&SECOND);
        let log = Self::default();
        let writer = log.clone();
        let lines = tracing_subscriber::fmt().with_max_level(most).with_ansi(false);
        let lines = lines.with_writer(move || writer.clone()).finish();
        (log, tracing::subscriber::set_default(lines))
    }

    /// Waits until these words were logged.
    pub async fn until(&self, words: &str) {
        let waited = async {
            while !self.text().contains(words) {
                tokio::time::sleep(Duration::from_millis(50)).await;
            }
        };
        let found = tokio::time::timeout(Duration::from_secs(30), waited).await;
        assert!(found.is_ok(), "{words:?} is not in the log:\n{}", self.text());
    }

    /// Forgets all of it so far.
    pub fn clear(&self) {
        self.0.lock().expect("not poisoned").clear();
    }

    /// All of it so far.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.0.lock().expect("not poisoned")).into_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says() {
        tracing::info!("both threads come here");
    }

    #[test]
    fn a_line_another_thread_came_to_first_is_in_the_log() {
        let (log, _guard) = Log::begin(LevelFilter::INFO);
        std::thread::spawn(says).join().expect("ends");
        says();
        assert_eq!(log.text().matches("both threads").count(), 1, "{}", log.text());
    }
}
