//! A drift in time next to the list: by how much the same circle reads longer from minute to minute.
//!
//! c: the time of each reading. Its amount next to the list is that of any other cause ([`super::confounded`]); u of every error of the list holds
//! the drift already, as it is learned with the noise.
//! Limits: a straight drift. One that comes and goes within the run shows by its mean slope.

use super::confounded::amount_next_to;
use super::trace::Trace;
use crate::common::significance::is_significant;
use nalgebra::{DMatrix, DVector};
use trunnion_core::convert::{s_from_min, um_from_mm};
use trunnion_core::number::um;

/// A significant drift.
pub(super) struct Drift {
    pub mm_per_s: f64,
    pub u: f64,
    /// From the first reading to the last.
    pub lasted_s: f64,
}

impl Drift {
    /// `design`: the columns of the list with its centring, `left`: what it leaves. `None` without times, or where noise alone may make it.
    pub fn of(trace: &Trace, design: &DMatrix<f64>, left: &DVector<f64>) -> Option<Self> {
        let times: Option<Vec<f64>> = trace.run.points.iter().map(|point| point.state.time_s).collect();
        let times = times.filter(|times| times.windows(2).all(|pair| pair[0] <= pair[1]))?;
        let (first_s, last_s) = (*times.first()?, *times.last()?);
        let column = DVector::from_iterator(times.len(), times.iter().map(|time_s| time_s - first_s));
        let (mm_per_s, u) = amount_next_to(design, &column, left)?;
        is_significant(mm_per_s, u, 1).then_some(Self { mm_per_s, u, lasted_s: last_s - first_s })
    }

    /// Its size, and what to do.
    pub fn words(&self) -> String {
        let of_minute = |mm_per_s: f64| um(um_from_mm(mm_per_s * s_from_min(1.0)));
        format!(
            "the readings drift by {} a minute (u {}), {} in all. The uncertainty of every error holds this drift. Let machine and bar warm up, then \
             measure again.",
            of_minute(self.mm_per_s),
            of_minute(self.u),
            um(um_from_mm(self.mm_per_s * self.lasted_s)),
        )
    }
}
