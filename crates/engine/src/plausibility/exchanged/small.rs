//! Mistakes that leave less than what is gross: the nest of one setup turned about its z axis, and readings that had not settled.
//!
//! Of balls set well a turn by some degrees leaves less than a machine may. It is named where the readings turned back fit as well as they repeat, as
//! readings some rows late are (`delayed`), or where it is believed as every other mistake is: physics would have to be, in one setup alone, what the
//! turn makes of all other errors. In 123 runs of two setups of the second simulator, with its physics known and unknown, no turn took more than 12 %
//! off what is left. Readings that had not settled repeat badly, so that what they leave does not look gross.

use super::{AS_GOOD, BELIEVED, CHANGE, DWELL, Trial, fits, unfit};
use crate::plausibility::fitted::Tried;
use crate::plausibility::found::Implausible;
use crate::plausibility::looked::Looked;
use std::ops::RangeInclusive;
use trunnion_cycles::RunKind;

/// Turned by no more, a nest may have been set by eye along an edge: 5° are 9 mm over its 100 mm, which everybody sees. Beyond that it was set
/// otherwise than its calibration says. By more than half a right angle all readings are others, which is gross; where it is not, as at the
/// short and the long tool after a correction that is right for the mean of both, the sign of what is left alone differs between setups.
const SMALL_DEG: RangeInclusive<i32> = 6..=45;
/// Undoing what then fits as well as it repeats divides what is left by this: mean square by four.
const DIVIDED: f64 = 2.0;

pub(in crate::plausibility) fn small(looked: &Looked) -> Option<Implausible> {
    let run = &looked.run;
    if run.setups.iter().any(|setup| setup.instrument.components().len() != 3) {
        return None;
    }
    let (repeated, before_mm) = (looked.repeated()?, looked.left_mm);
    if fits(&repeated, before_mm) {
        return None;
    }
    let trial = Trial::of(looked);
    let turned = trial.setups_turned().into_iter().map(|one| (one, CHANGE));
    let unsettled = (run.kind == RunKind::Static).then(|| trial.unsettled()).flatten();
    let tried = turned.chain(unsettled.map(|one| (one, DWELL)));
    let ((words, left_mm), to_do) = tried.min_by(|((_, a), _), ((_, b), _)| a.total_cmp(b))?;
    let divided = if fits(&repeated, left_mm) { DIVIDED } else { BELIEVED };
    let is_believed = before_mm > divided * left_mm && trial.of_an_effect_mm() > AS_GOOD * left_mm;
    is_believed.then(|| unfit(run, &repeated, before_mm, (words, left_mm), to_do))
}

impl Trial<'_> {
    /// Each of several setups turned about z.
    fn setups_turned(&self) -> Vec<Tried> {
        let setups = &self.run.setups;
        let has_points = |setup: &usize| !self.points_of(Some(*setup)).is_empty();
        let turned = (0..setups.len()).filter(|_| setups.len() > 1).filter(has_points).map(|setup| {
            let (words, left_mm) = self.turned_about_z(setup, SMALL_DEG);
            (format!("{words} (setup {} alone)", setups[setup].name), left_mm)
        });
        turned.collect()
    }
}
