//! Rows of another day, or another machine, in one file: from a point on the readings fit location errors and settings of their own, and only
//! such.
//!
//! A shift (a slip, a pass that lies elsewhere) has no other location errors, and a machine that warms up goes there by and by: both must leave
//! far more.

use super::{BELIEVED, Trial};
use crate::plausibility::fitted::{Tried, columns};
use crate::problem::passes::passes;

/// Fewer points, 72 readings for some 14 location errors and settings of their own, fit whatever they are.
const FEWEST: usize = 24;

impl Trial<'_> {
    /// From the beginning of the pass or setup with which least is left.
    pub(super) fn of_parts(&self) -> Option<Tried> {
        let points = &self.experiment.points;
        let passes = passes(self.experiment);
        let begins = |at: &usize| {
            points[*at].state.setup != points[at - 1].state.setup || passes.pass[*at] != passes.pass[at - 1]
        };
        let columns = columns(self.experiment)?;
        let readings_mm = self.experiment.readings_mm();
        let with = |share: &dyn Fn(usize) -> f64| {
            let mut own = columns.clone();
            for at in 0..points.len() {
                self.experiment.rows_of(at).for_each(|row| own.row_mut(row).scale_mut(share(at)));
            }
            self.model.rms_with_mm(&own, &readings_mm)
        };
        let last = points.len().checked_sub(FEWEST)?;
        let parts = (FEWEST..=last).filter(begins);
        let tried = parts.map(|from| (from, with(&|at| f64::from(u8::from(at >= from)))));
        let (from, left_mm) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let shifted_mm = self.model.rms_with_mm(&self.shift_from(from), &readings_mm);
        let by_and_by_mm = with(&|at| at as f64 / points.len() as f64);
        let share = 100.0 * from as f64 / points.len() as f64;
        (BELIEVED * left_mm < shifted_mm.min(by_and_by_mm)).then(|| {
            let words = format!(
                "other location errors from {share:.0} % of the points on (rows of another day or another machine)"
            );
            (words, left_mm)
        })
    }
}
