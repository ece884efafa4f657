//! What a person at the page or the broker asks of the service: which cycle is next, that it begins now, that it ends now.

use crate::refused::Refused;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;
use trunnion::results::ChoiceRefused;

/// Longest name that is looked for, bytes: the recording of a cycle is a file of its name, and no file of Linux has a longer one (NAME_MAX).
const LONGEST_NAME: usize = 255;

/// Shared by who asks and by who measures.
#[derive(Clone, Default)]
pub struct Operator {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    /// Names of the cycles that can be chosen; none where nothing waits for one.
    offered: Mutex<Vec<String>>,
    chosen: Mutex<Option<String>>,
    refused: Mutex<Option<ChoiceRefused>>,
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
    /// From now on these cycles can be chosen.
    pub fn offer<'a>(&self, cycles: impl Iterator<Item = &'a str>) {
        *lock(&self.shared.offered) = cycles.map(str::to_owned).collect();
    }

    /// This cycle is measured next, whatever program runs; an empty name takes the choice back.
    ///
    /// # Errors
    /// When there is no such cycle: the choice before stays.
    pub fn choose(&self, cycle: &str) -> Result<(), Refused> {
        let cycle = cycle.trim();
        if cycle.len() > LONGEST_NAME {
            return Err(Refused::Name { bytes: cycle.len() });
        }
        let offered = lock(&self.shared.offered);
        let chosen = Some(cycle.to_owned()).filter(|cycle| !cycle.is_empty());
        if chosen.is_some() && !offered.iter().any(|name| name == cycle) {
            return Err(Refused::no_cycle(cycle, offered.iter().map(String::as_str)));
        }
        *self.chosen() = chosen;
        *lock(&self.shared.refused) = None;
        Ok(())
    }

    /// The same for what came without an answer back, in any bytes: what is refused is kept for `status`, and true where it is other than
    /// what was refused before.
    ///
    /// # Errors
    /// As [`Self::choose`], and where it is no text.
    pub fn choose_unanswered(&self, cycle: &[u8]) -> Result<(), (Refused, bool)> {
        let no_name = |_| Refused::Name { bytes: cycle.len() };
        let chosen = std::str::from_utf8(cycle).map_err(no_name).and_then(|cycle| self.choose(cycle));
        chosen.map_err(|refused| {
            let (mut kept, why) = (lock(&self.shared.refused), refused.to_string());
            let same = kept.as_ref().filter(|kept| kept.why == why).map(|kept| kept.times);
            *kept = Some(ChoiceRefused { why, times: same.unwrap_or(0) + 1 });
            (refused, same.is_none())
        })
    }

    /// The last choice that was refused and got no answer; `None` after one that was taken.
    pub fn refused(&self) -> Option<ChoiceRefused> {
        lock(&self.shared.refused).clone()
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
        lock(&self.shared.chosen)
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_measured_is_refused_at_once_and_counted() {
        let operator = Operator::default();
        operator.offer(["demo-static", "demo-sweep-c"].into_iter());
        operator.choose_unanswered(b"demo-static").unwrap();
        let check = |sent: &[u8], words: &str, is_new: bool, times: u64| {
            let (refused, was_new) = operator.choose_unanswered(sent).unwrap_err();
            let kept = operator.refused().unwrap();
            assert!(kept.why == refused.to_string() && kept.why.contains(words), "{kept:?}");
            assert!(kept.why.len() < 300 && !kept.why.contains('\n'), "{kept:?}");
            assert_eq!((was_new, kept.times), (is_new, times), "{kept:?}");
            assert_eq!(operator.peek_chosen().as_deref(), Some("demo-static"), "the choice before stays");
        };
        check(b"demo-statik", "did you mean demo-static?", true, 1);
        check(b"demo-statik", "did you mean demo-static?", false, 2);
        check(b"low\nlevel=ERROR", "\\nlevel", true, 1);
        check(&[0xff; 5], "5 bytes", true, 1);
        check(&[b'x'; 100_000], "100000 bytes", true, 1);
        operator.choose_unanswered(b"").unwrap();
        assert_eq!((operator.peek_chosen(), operator.refused()), (None, None));
    }
}
