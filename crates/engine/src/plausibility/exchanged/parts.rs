//! Rows of another day, or another machine, in one file, or of a correction that was switched on or off: from a point on, or in some passes, the
//! readings fit location errors and settings of their own, and only such.
//!
//! A shift (a slip, a pass that lies elsewhere) has no other location errors, and a machine that warms up goes there by and by: both must leave
//! far more.

use super::{BELIEVED, Trial};
use crate::plausibility::fitted::{Tried, columns};
use crate::problem::passes::passes;
use nalgebra::DMatrix;
use std::ops::Range;

/// Fewer points, 72 readings for some 14 location errors and settings of their own, fit whatever they are.
const FEWEST: usize = 24;
/// Points that are tried at once as the first of a part, evenly; then those next to the best. For time only.
const TRIED_AT_ONCE: usize = 100;
/// Beginnings of passes between every two of which a part is tried, evenly: 435 parts. For time only.
const BETWEEN: usize = 30;

impl Trial<'_> {
    /// From the beginning of the pass or setup with which least is left, in the passes with which it is, and from such a point of any pass on.
    pub(super) fn of_parts(&self) -> Vec<Tried> {
        let Some(parts) = Parts::of(self) else { return Vec::new() };
        let count = self.experiment.points.len();
        let begins = self.begins();
        let to_the_end = begins.iter().map(|&first| first..count);
        let some: Vec<usize> =
            begins.iter().copied().step_by(begins.len().div_ceil(BETWEEN).max(1)).collect();
        let between = some.iter().enumerate();
        let between = between.flat_map(|(k, &first)| some[k + 1..].iter().map(move |&end| first..end));
        [parts.best(to_the_end), parts.best(between), parts.best_from_any_point()]
            .into_iter()
            .flatten()
            .filter_map(|(part, left_mm)| parts.believed(&part, left_mm))
            .collect()
    }

    /// Where passes and setups begin, but for the first.
    fn begins(&self) -> Vec<usize> {
        let points = &self.experiment.points;
        let passes = passes(self.experiment);
        let begins = |at: &usize| {
            points[*at].state.setup != points[at - 1].state.setup || passes.pass[*at] != passes.pass[at - 1]
        };
        (1..points.len()).filter(begins).collect()
    }
}

struct Parts<'a> {
    trial: &'a Trial<'a>,
    /// Of the base model.
    columns: DMatrix<f64>,
}

impl<'a> Parts<'a> {
    fn of(trial: &'a Trial<'a>) -> Option<Self> {
        Some(Self { trial, columns: columns(trial.experiment)? })
    }

    fn best(&self, parts: impl Iterator<Item = Range<usize>>) -> Option<(Range<usize>, f64)> {
        let count = self.trial.experiment.points.len();
        let long_enough = |part: &Range<usize>| part.len() >= FEWEST && count - part.len() >= FEWEST;
        let tried = parts.filter(long_enough).map(|part| {
            let left_mm = self.left_mm(|at| f64::from(u8::from(part.contains(&at))));
            (part, left_mm)
        });
        tried.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn best_from_any_point(&self) -> Option<(Range<usize>, f64)> {
        let count = self.trial.experiment.points.len();
        let every = count.div_ceil(TRIED_AT_ONCE);
        let (near, _) = self.best((FEWEST..count).step_by(every).map(|first| first..count))?;
        self.best((near.start.saturating_sub(every)..near.start + every).map(|first| first..count))
    }

    fn believed(&self, part: &Range<usize>, left_mm: f64) -> Option<Tried> {
        let trial = self.trial;
        let count = trial.experiment.points.len() as f64;
        let shifted_mm =
            trial.model.rms_with_mm(&trial.shift_of(part.clone()), &trial.experiment.readings_mm());
        let by_and_by_mm = self.left_mm(|at| at as f64 / count);
        let percent = |at: usize| format!("{:.0}", 100.0 * at as f64 / count);
        let first = percent(part.start);
        let where_it_is = match percent(part.end) {
            last if last == "100" => format!("from {first} % of the points on"),
            last => format!("from {first} % to {last} % of the points"),
        };
        (BELIEVED * left_mm < shifted_mm.min(by_and_by_mm)).then(|| {
            let words = format!(
                "other location errors {where_it_is} (rows of another day or another machine, or a correction was switched on or off)"
            );
            (words, left_mm)
        })
    }

    /// What the base model leaves with one more of its own, of which the points have a share, mm rms.
    fn left_mm(&self, share: impl Fn(usize) -> f64) -> f64 {
        let experiment = self.trial.experiment;
        let mut own = self.columns.clone();
        for at in 0..experiment.points.len() {
            experiment.rows_of(at).for_each(|row| own.row_mut(row).scale_mut(share(at)));
        }
        self.trial.model.rms_with_mm(&own, &experiment.readings_mm())
    }
}
