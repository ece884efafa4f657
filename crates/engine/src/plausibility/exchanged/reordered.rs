//! Readings in another order than the positions: a table of which some columns were sorted, or reversed, and the others not.
//!
//! Which reading belongs to which pose is lost then, but poses are measured in few orders: one pass after the other over a grid, and columns are
//! sorted by one axis or two. Readings are given to the poses in each of these orders.
//! A drift follows the rows and not the poses, as such readings do: the order has to leave far less than any drift.
//! Limits: a random order does not come back; one that takes equal poses for each other changes nothing, and is not found.

mod orders;

use super::{BELIEVED, Trial};
use crate::Experiment;
use crate::plausibility::fitted::{Fitted, Tried, columns, rms};
use crate::plausibility::looked::MOST_POINTS;
use nalgebra::{DMatrix, DVector};
use orders::orders;
use std::f64::consts::PI;

/// Half waves of a drift over a run: what warms up and cools down twice.
const DRIFT_WAVES: usize = 4;

impl Trial<'_> {
    /// The order with which least is left.
    pub(super) fn reordered(&self) -> Option<Tried> {
        let whole = self.looked.whole;
        if whole.points.len() > MOST_POINTS || whole.good_points().count() < whole.points.len() {
            return None;
        }
        let experiment = Experiment::of_points(std::slice::from_ref(whole)).ok()?;
        let channels = experiment.rows_of(0).len();
        if (0..experiment.points.len()).any(|at| experiment.rows_of(at).len() != channels) {
            return None;
        }
        let columns = columns(&experiment)?;
        let fitted = Fitted::on(&columns, |_| true);
        let left_mm = |order: &[usize]| {
            // A reading that no fit keeps goes along with its order, to another pose.
            let mut is_used = self.looked.kept.clone();
            let mut readings_mm = DVector::zeros(experiment.rows());
            for (reading, &pose) in order.iter().enumerate() {
                is_used[pose] &= self.looked.kept[reading];
                let given_mm = whole.points[reading].reading_mm;
                experiment.rows_of(pose).zip(given_mm).for_each(|(row, mm)| readings_mm[row] = mm);
            }
            if is_used.iter().all(|used| *used) {
                return fitted.rms_mm(&readings_mm);
            }
            let of_used = Fitted::on(&columns, |row| is_used[row / channels]);
            let left_mm = of_used.left_mm(&readings_mm);
            let used: Vec<f64> =
                (0..left_mm.len()).filter(|row| is_used[row / channels]).map(|row| left_mm[row]).collect();
            rms(&DVector::from_vec(used))
        };
        let tried = orders(&experiment).into_iter().map(|order| (order.words, left_mm(&order.poses)));
        let best = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let with_drift_mm = self.model.rms_with_mm(&self.drift(), &self.experiment.readings_mm());
        (BELIEVED * best.1 < with_drift_mm).then_some(best)
    }

    /// What goes by slowly from row to row, every channel by itself: cos(πmk/n) at row k of n. Sorted by an axis it looks like an error of that axis.
    fn drift(&self) -> DMatrix<f64> {
        let (experiment, count) = (self.experiment, self.experiment.points.len());
        let channels = experiment.rows_of(0).len();
        let mut columns = DMatrix::zeros(experiment.rows(), DRIFT_WAVES * channels);
        for at in 0..count {
            for (channel, row) in experiment.rows_of(at).enumerate() {
                for wave in 0..DRIFT_WAVES {
                    let phase = PI * (wave + 1) as f64 * at as f64 / count as f64;
                    columns[(row, channel * DRIFT_WAVES + wave)] = phase.cos();
                }
            }
        }
        columns
    }
}
