//! Connections by who has them: one other computer does not take all.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Connections at once: two browsers have twelve.
pub(super) const MOST_CONNECTIONS: usize = 64;
/// Connections of one other computer at once: three browsers have eighteen.
const MOST_OF_ONE: usize = 18;

/// How many each has.
#[derive(Clone, Default)]
pub(super) struct Places(Arc<Mutex<BTreeMap<IpAddr, usize>>>);

/// A connection that is counted until this is dropped.
pub(super) struct Place {
    places: Places,
    of: IpAddr,
}

impl Places {
    /// A place for one connection more; `None` where that computer has too many. Programs of this computer share all.
    pub(super) fn take(&self, of: IpAddr) -> Option<Place> {
        let mut counts = self.lock();
        let count = counts.entry(of).or_default();
        if *count >= MOST_OF_ONE && !of.is_loopback() {
            return None;
        }
        *count += 1;
        drop(counts);
        Some(Place { places: self.clone(), of })
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<IpAddr, usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut counts = self.places.lock();
        if let Some(count) = counts.get_mut(&self.of) {
            *count -= 1;
            if *count == 0 {
                counts.remove(&self.of);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_other_computer_does_not_take_all_and_what_ends_makes_room() {
        let (places, one, other) = (Places::default(), [10, 0, 0, 1].into(), [10, 0, 0, 2].into());
        let mut held: Vec<Place> = (0..MOST_OF_ONE).filter_map(|_| places.take(one)).collect();
        assert_eq!(held.len(), MOST_OF_ONE);
        assert!(places.take(one).is_none());
        assert!(places.take(other).is_some());
        held.pop();
        assert!(places.take(one).is_some());
        drop(held);
        assert!(places.lock().is_empty(), "nothing is kept of who left");
    }
}
