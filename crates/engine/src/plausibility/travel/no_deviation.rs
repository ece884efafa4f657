//! Readings that are the targets: no axis is without errors, and the air alone moves a beam by more than its last digit.

use super::Line;
use crate::plausibility::found::{Implausible, plain};
use trunnion_core::convert::um_from_mm;

/// The last digit that lasers show, mm. Still air over half a metre moves a reading by ten of it or more.
const LAST_DIGIT_MM: f64 = 1e-6;

/// Travel over which every axis has errors that a display of 1 µm shows: good scales err by 5 µm/m. Over a shorter one it may show none. A judgement,
/// tuned on no data.
const LEAST_RANGE_MM: f64 = 100.0;

/// Range of all deviations of a travel, as a share of it, below which the unit is doubted: interferometers with compensation of the air are right to
/// 0.5 µm/m (95 %) [Renishaw XL-80, data sheet], and axes are worse than what measures them. 10 µm over 400 mm is 2.5e-8 where mm are taken for µm.
const LEAST_SHARE: f64 = 5e-7;

impl Line<'_> {
    pub(super) fn no_deviation(&self) -> Option<Implausible> {
        let off_mm = &self.readings_mm - &self.nominal_mm;
        let range_mm = self.nominal_mm.max() - self.nominal_mm.min();
        let off_range_mm = off_mm.max() - off_mm.min();
        if range_mm >= LEAST_RANGE_MM && (LAST_DIGIT_MM..LEAST_SHARE * range_mm).contains(&off_range_mm) {
            return Some(plain(
                format!(
                    "{}: in setup {} all deviations from the targets lie within {:.3} µm over {range_mm:.0} mm: no axis and no laser is so good.",
                    self.run.name,
                    self.name,
                    um_from_mm(off_range_mm)
                ),
                "In mm instead of µm (factor 1000) they would be plausible. Check the unit of the deviations, unless the run was simulated without errors \
                 and noise.",
            ));
        }
        (range_mm >= LEAST_RANGE_MM && off_range_mm < LAST_DIGIT_MM).then(|| {
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
