//! Readings with one component reversed: a probe of the other sense, or a machine that is a mirror image of what its file says.

use super::Trial;
use crate::plausibility::mirrored;
use crate::plausibility::positions::claimed;

impl Trial<'_> {
    /// Words of the mirror that leaves as little, and what tells it from a probe; `None` where no machine in a mirror fits the positions.
    pub(super) fn mirror(&self, most_left_mm: f64) -> Option<(String, String)> {
        let rows: Vec<usize> = (0..self.run.points.len()).collect();
        let claim = claimed(self.run, &rows);
        let reversed =
            |probe: &usize| self.changed_mm(None, |reading| reading[*probe] *= -1.0) <= most_left_mm;
        let probe = (0..3).filter(|_| self.has_three()).find(reversed)?;
        let mirror = mirrored::as_good(&claim, probe)?;
        let words = format!(
            "the senses of {}, and of {}, reversed together (sign −1), as the readings are those of a machine in a mirror",
            mirror.rotary_names(),
            mirror.linear
        );
        Some((words, mirror.distinguished_by()))
    }
}
