//! Probe inputs that were exchanged, or turned round, or readings of which one was lost or doubled, while a run went on; and readings of which
//! one was lost and a later one doubled, or the other way round, so that those between the two are late or early, or of which a block has lost its
//! minus signs and got others.
//!
//! Of a machine with small errors alone, a shift from that point on (a slip, the other direction of an axis with play) looks like a change of
//! sign. So the mistake has to leave far less than any shift there.

use super::axes::{Way, ways};
use super::{BELIEVED, Trial};
use crate::plausibility::fitted::Tried;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Fewer points are single wrong ones, or too few to tell.
const FEWEST: usize = 12;

impl Trial<'_> {
    /// Every way from the point on with which least is left.
    pub(super) fn changed_at_a_point(&self) -> Vec<Tried> {
        let (experiment, count) = (self.experiment, self.experiment.points.len());
        if count < 2 * FEWEST {
            return Vec::new();
        }
        let points: Vec<usize> = (FEWEST..=count - FEWEST).collect();
        let rows: Vec<usize> = points.iter().map(|&at| experiment.rows_of(at).start).collect();
        let as_given = experiment.readings_mm();
        let of_change = |(words, changed): (String, DVector<f64>)| {
            let left_mm = self.model.left_of_switch_mm(&as_given, &changed, &rows);
            let (_, &from) = left_mm.into_iter().zip(&points).min_by(|a, b| a.0.total_cmp(&b.0))?;
            let left_mm = self.model.rms_mm(&self.spliced(&changed, from..count));
            if BELIEVED * left_mm > self.model.rms_with_mm(&self.shift_from(from), &as_given) {
                return None;
            }
            let share = 100.0 * from as f64 / count as f64;
            Some((format!("{words} from {share:.0} % of the points on"), left_mm))
        };
        let of_way = |way: Way| {
            let change = |readings: &mut [[f64; 3]]| readings.iter_mut().for_each(|one| way.apply(one));
            (way.words(), self.changed_rows(change))
        };
        let late = self
            .late_rows(None, &[0, 1, 2], 1)
            .map(|(words, changed)| (format!("the readings {words}"), changed));
        ways().into_iter().map(of_way).chain(late).filter_map(of_change).collect()
    }

    /// Readings one row late or early, or with every sign reversed, between the two points with which least is left.
    pub(super) fn changed_between_points(&self) -> Vec<Tried> {
        let (experiment, count) = (self.experiment, self.experiment.points.len());
        let rows: Vec<usize> = (0..count).map(|at| experiment.rows_of(at).start).collect();
        let as_given = experiment.readings_mm();
        let of_change = |(words, changed): (String, DVector<f64>)| {
            let (window, _) = self.model.least_of_windows_mm(&as_given, &changed, &rows)?;
            let [first, last] = window.map(|row| rows.partition_point(|&begins| begins < row));
            let left_mm = self.model.rms_mm(&self.spliced(&changed, first..last));
            let shifted_mm = self.model.rms_with_mm(&self.shift_of(first..last), &as_given);
            (last - first >= FEWEST && BELIEVED * left_mm <= shifted_mm).then(|| {
                let [first, last] = [first, last].map(|at| 100.0 * at as f64 / count as f64);
                (format!("{words} from {first:.0} % to {last:.0} % of the points"), left_mm)
            })
        };
        let late = self.late_rows(None, &[0, 1, 2], 1);
        let late = late.map(|(words, changed)| (format!("the readings {words}"), changed));
        let reversed = ("the signs of all readings reversed".to_string(), -&as_given);
        late.into_iter().chain([reversed]).filter_map(of_change).collect()
    }

    /// The readings as they are, with some points as changed.
    fn spliced(&self, changed: &DVector<f64>, points: Range<usize>) -> DVector<f64> {
        let mut readings_mm = self.experiment.readings_mm();
        for row in points.flat_map(|at| self.experiment.rows_of(at)) {
            readings_mm[row] = changed[row];
        }
        readings_mm
    }

    /// A shift of every channel from a point on.
    pub(super) fn shift_from(&self, from: usize) -> DMatrix<f64> {
        self.shift_of(from..self.experiment.points.len())
    }

    /// The same of some points.
    pub(super) fn shift_of(&self, points: Range<usize>) -> DMatrix<f64> {
        let mut shift = DMatrix::zeros(self.experiment.rows(), 3);
        for at in points {
            self.experiment.rows_of(at).enumerate().for_each(|(channel, row)| shift[(row, channel)] = 1.0);
        }
        shift
    }
}
