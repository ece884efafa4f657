//! What one thread logs, for tests that look into it.

use std::sync::{Arc, Mutex};
use std::time::Duration;
use tracing::level_filters::LevelFilter;
use tracing::subscriber::DefaultGuard;

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
