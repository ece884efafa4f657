//! Whether a cycle may begin, said when it changes.

use std::fmt;
use trunnion::results::Zone;

/// What stands against a cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct NotReady {
    /// Name of the channel or device.
    pub source: String,
    /// What kind of doubt it is.
    pub zone: Zone,
    /// What is wrong and what to do.
    pub why: String,
}

impl fmt::Display for NotReady {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.source, self.why)
    }
}

/// Devices have so many seconds to connect and to show their first values before they are said to be missing.
const CONNECTING: u32 = 3;

/// Says whether a cycle may begin while none is measured.
#[derive(Debug, Default)]
pub struct Readiness {
    said: Option<Vec<NotReady>>,
    asked: u32,
}

impl Readiness {
    /// What stands against a cycle `now` (as the latest values say), where that is other than what was said last; to be
    /// asked once a second.
    pub fn changed(&mut self, now: Option<Vec<NotReady>>) -> Option<&[NotReady]> {
        self.asked += 1;
        let now = now?;
        let is_early = self.asked <= CONNECTING && !now.is_empty();
        // The numbers in a sentence change all the time.
        let same = |a: &NotReady, b: &NotReady| a.source == b.source && a.zone == b.zone;
        let said =
            |said: &Vec<NotReady>| said.len() == now.len() && said.iter().zip(&now).all(|(a, b)| same(a, b));
        if is_early || self.said.as_ref().is_some_and(said) {
            return None;
        }
        Some(self.said.insert(now).as_slice())
    }
}
