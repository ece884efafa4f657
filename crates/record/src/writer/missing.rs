//! A journal that is not at its place: it may come back, or is lost.

use super::kept::Missing;
use super::{REASON_LATER, Recorder};

impl Recorder {
    /// The journal is not at its place.
    pub(super) fn abandon_missing(&mut self) {
        if let (Some(mut journal), Some(kept)) = (self.journal.take(), self.journals.pop()) {
            journal.abandon();
            self.missing = Some(Missing { kept, journal });
        }
    }

    /// A folder on the network may miss a file for a moment: one that is there again belongs to the run.
    pub(super) fn look_for_missing(&mut self) {
        self.journals.extend(self.missing.take_if(|missing| missing.is_there()).map(|missing| missing.kept));
    }

    /// What was in a missing journal is lost. The next one may have its name by now.
    pub(super) fn settle_missing(&mut self) {
        if let Some(Missing { kept, .. }) = self.missing.take() {
            self.lost_samples += kept.samples;
            kept.lose(&mut self.lost, REASON_LATER);
        }
    }
}
