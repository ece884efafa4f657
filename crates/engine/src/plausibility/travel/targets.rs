//! Positions that hold what was read instead of the targets.
//!
//! Rounded to their last digit q, they leave no more than a rounding of what is read: ±q/2 along each axis. A target stays the same from pass to
//! pass; positions that were read come again as badly as the axis does. Those of an encoder do so too, but the errors of the axis stay next to them: together
//! with the rounding they are wider than a digit.
//! Limits: where no target is measured twice, positions that were read are no different from targets of an axis without errors.

use super::Line;
use crate::plausibility::found::{Implausible, plain};
use crate::plausibility::readings::FEWEST_POINTS;
use crate::plausibility::shown::SAME_MM;
use trunnion_core::Joint;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::fixed;
use trunnion_core::statistics::upper_median;

/// Positions that differ by less are of one target, mm: axes come within micrometres of it, and the next target is farther away.
const ONE_TARGET_MM: f64 = 0.1;
/// Digits of positions that are asked for, of mm; finer ones are those of a computation.
const MOST_DIGITS: i32 = 5;
/// The same targets come again: share of the positions that have another within so little. Targets that are met once lie so near here and there
/// only.
const COMING_BACK: f64 = 0.5;
/// What comes back differs by micrometres: of the differences within a target, the usual one is so small, mm. Of targets that lie near each other
/// by chance it is half of [`ONE_TARGET_MM`].
const COMES_WITHIN_MM: f64 = ONE_TARGET_MM / 4.0;
/// Targets at which positions differ, as a share of all. What comes back within r takes another digit q at about 2r/q of them: with fewer, it would
/// come back within a sixth of a digit.
const DIFFERING: f64 = 1.0 / 3.0;

impl Line<'_> {
    pub(super) fn no_targets(&self) -> Option<Implausible> {
        let digit_mm = self.last_digit_mm()?;
        let off_mm = &self.readings_mm - &self.nominal_mm;
        let along: f64 = self.direction.iter().map(|share| share.abs()).sum();
        // Both ends may be off by their rounding in addition.
        if off_mm.max() - off_mm.min() > 1.01 * along * digit_mm {
            return None;
        }
        let mut nominal_mm: Vec<f64> = self.nominal_mm.iter().copied().collect();
        nominal_mm.sort_by(f64::total_cmp);
        let targets: Vec<&[f64]> =
            nominal_mm.chunk_by(|a, b| b - a < ONE_TARGET_MM).filter(|own| own.len() > 1).collect();
        let differs = |own: &&&[f64]| own.iter().any(|mm| mm - own[0] > SAME_MM);
        let differing = targets.iter().filter(differs).count();
        let again: usize = targets.iter().map(|own| own.len()).sum();
        let gaps = targets.iter().flat_map(|own| own.windows(2)).map(|pair| pair[1] - pair[0]);
        let gaps_mm: Vec<f64> = gaps.filter(|mm| *mm > SAME_MM).collect();
        let comes_back = again as f64 > COMING_BACK * nominal_mm.len() as f64
            && upper_median(&gaps_mm).is_some_and(|usual_mm| usual_mm < COMES_WITHIN_MM);
        (again >= FEWEST_POINTS && comes_back && differing as f64 > DIFFERING * targets.len() as f64).then(|| {
            plain(
                format!(
                    "{}: the positions of setup {} do not come back to their targets: at {differing} of {} they differ, as the readings do, which they equal \
                     within {} µm, half of their last digit.",
                    self.run.name,
                    self.name,
                    targets.len(),
                    fixed(um_from_mm(digit_mm) / 2.0, 1),
                ),
                "The positions are what was read, not the targets, so that no error is left. Put in the positions that the program asked for.",
            )
        })
    }

    /// The last digit of the positions of the linear axes, mm; `None` where they are computed.
    fn last_digit_mm(&self) -> Option<f64> {
        let positions = || {
            self.run.good_points().flat_map(|point| Joint::LINEAR.map(|joint| point.state.position[joint]))
        };
        let digits = (0..=MOST_DIGITS).find(|digits| {
            let scale = 10_f64.powi(*digits);
            // The value of a decimal number is off by far less.
            positions().all(|mm| (mm * scale - (mm * scale).round()).abs() < 1e-4)
        })?;
        Some(10_f64.powi(-digits))
    }
}
