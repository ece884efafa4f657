//! What a person at the page or the broker asks of the service: which cycle is next, that it begins now, that it ends now.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;

/// Shared by who asks and by who measures.
#[derive(Clone, Default)]
pub struct Operator {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    chosen: Mutex<Option<String>>,
    /// Counts what was asked.
    begun: watch::Sender<u64>,
    aborted: watch::Sender<u64>,
}

/// Waits for what is asked from now on.
pub struct Asked {
    /// Keeps the senders.
    _operator: Operator,
    begun: watch::Receiver<u64>,
    aborted: watch::Receiver<u64>,
}

impl Operator {
    /// This cycle is measured next, whatever program runs; an empty name takes the choice back.
    pub fn choose(&self, cycle: &str) {
        let cycle = cycle.trim();
        *self.chosen() = Some(cycle.to_owned()).filter(|cycle| !cycle.is_empty());
    }

    /// What was chosen, once.
    pub fn take_chosen(&self) -> Option<String> {
        self.chosen().take()
    }

    /// What is chosen.
    pub fn peek_chosen(&self) -> Option<String> {
        self.chosen().clone()
    }

    /// The next cycle begins now, whatever the controller shows. Nothing while one is measured.
    pub fn begin(&self) {
        self.shared.begun.send_modify(|times| *times += 1);
    }

    /// The cycle that is measured ends now; what was read is kept. Nothing while none is measured.
    pub fn abort(&self) {
        self.shared.aborted.send_modify(|times| *times += 1);
    }

    /// For who measures.
    pub fn asked(&self) -> Asked {
        let (begun, aborted) = (self.shared.begun.subscribe(), self.shared.aborted.subscribe());
        Asked { _operator: self.clone(), begun, aborted }
    }

    fn chosen(&self) -> MutexGuard<'_, Option<String>> {
        self.shared.chosen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Asked {
    /// Forgets what was asked before: it was not meant for what comes now.
    pub fn forget(&mut self) {
        self.begun.mark_unchanged();
        self.aborted.mark_unchanged();
    }

    /// A cycle is to begin. Cancel safe.
    pub async fn begins(&mut self) {
        if self.begun.changed().await.is_err() {
            std::future::pending().await
        }
    }

    /// The cycle is to end. Cancel safe.
    pub async fn aborts(&mut self) {
        if self.aborted.changed().await.is_err() {
            std::future::pending().await
        }
    }
}
