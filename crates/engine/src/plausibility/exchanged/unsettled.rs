//! Readings that were taken before they had settled, so that each holds a share of the one before: reading = true + share·(before − true).
//!
//! With g = share/(1 − share), true = reading + g·(reading − before), linear in g. What varies smoothly from pose to pose, as physics does,
//! goes along with its own difference from the pose before, and asks for a negative g: it cannot look like this.

use super::Trial;
use crate::plausibility::fitted::{Tried, rms};

/// Less of the reading before is no gross mistake; more of it leaves nothing of the own.
const SHARES: std::ops::Range<f64> = 0.03..0.9;

impl Trial<'_> {
    /// Of all probes; one alone repeats worse than the others.
    pub(super) fn unsettled(&self) -> Option<Tried> {
        let points = &self.experiment.points;
        let steps_mm = self.changed_rows(|readings| {
            for (at, reading) in readings.iter_mut().enumerate() {
                // Between setups there is time enough.
                let before = at.checked_sub(1).map(|before| &points[before]);
                let before = before.filter(|before| before.state.setup == points[at].state.setup);
                let before_mm = before.map_or(*reading, |before| before.reading_mm);
                reading.iter_mut().zip(before_mm).for_each(|(value, before_mm)| *value -= before_mm);
            }
        });
        let left_mm = self.model.left_mm(&self.experiment.readings_mm());
        let steps_mm = self.model.left_mm(&steps_mm);
        let gain = -left_mm.dot(&steps_mm) / steps_mm.norm_squared();
        let share = gain / (1.0 + gain);
        SHARES.contains(&share).then(|| {
            let words = format!(
                "{:.0} % of the reading before taken out of every reading: they were taken before they had settled",
                100.0 * share
            );
            (words, rms(&(left_mm + gain * steps_mm)))
        })
    }
}
