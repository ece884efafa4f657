//! Probe inputs that were exchanged, or turned round, while a run went on.
//!
//! Of a machine with small errors alone, a shift from that point on (a slip, the other direction of an axis with play) looks like a change of
//! sign. So the mistake has to leave far less than any shift there.

use super::axes::ways;
use super::{BELIEVED, Trial};
use crate::plausibility::fitted::Tried;
use nalgebra::DMatrix;

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
        let of_way = |way: super::axes::Way| {
            let changed = self.changed_rows(|readings| readings.iter_mut().for_each(|one| way.apply(one)));
            let left_mm = self.model.left_of_switch_mm(&as_given, &changed, &rows);
            let least = left_mm.into_iter().zip(&points).min_by(|a, b| a.0.total_cmp(&b.0))?;
            let mut shift = DMatrix::zeros(as_given.len(), 3);
            for at in *least.1..count {
                experiment.rows_of(at).enumerate().for_each(|(channel, row)| shift[(row, channel)] = 1.0);
            }
            if BELIEVED * least.0 > self.model.rms_with_mm(&shift, &as_given) {
                return None;
            }
            let share = 100.0 * *least.1 as f64 / count as f64;
            Some((format!("{} from {share:.0} % of the points on", way.words()), least.0))
        };
        ways().into_iter().filter_map(of_way).collect()
    }
}
