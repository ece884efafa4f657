//! Readings that are the targets: no axis is without errors, and the air alone moves a beam by more than its last digit.

use super::Line;
use crate::plausibility::found::{Implausible, plain};

/// The last digit that lasers show, mm. Still air over half a metre moves a reading by ten of it or more.
const LAST_DIGIT_MM: f64 = 1e-6;

/// Travel over which every axis has errors that a display of 1 µm shows: good scales err by 5 µm/m. Over a shorter one it may show none. A judgement,
/// tuned on no data.
const LEAST_RANGE_MM: f64 = 100.0;

impl Line<'_> {
    pub(super) fn no_deviation(&self) -> Option<Implausible> {
        let off_mm = &self.readings_mm - &self.nominal_mm;
        let range_mm = self.nominal_mm.max() - self.nominal_mm.min();
        (range_mm >= LEAST_RANGE_MM && off_mm.max() - off_mm.min() < LAST_DIGIT_MM).then(|| {
            plain(
                format!(
                    "{}: in setup {} all {} readings follow their targets to the last digit: no axis and no laser does.",
                    self.run.name,
                    self.name,
                    off_mm.len()
                ),
                "The targets stand in the column of the readings, or the display is so coarse that it shows nothing else. Put in what the laser read, with \
                 four decimals or more; unless the run was simulated without errors and noise.",
            )
        })
    }
}
