//! Plain least squares of the model and chosen columns over the points of a scan: what the search sees of a set of effects.
//!
//! For the search alone: what is printed of an effect comes from [`crate::problem::Problem::with`].

use crate::diagnosis::scan::Scan;
use crate::evidence::stacked;
use crate::noise::outliers::excluded;
use crate::problem::design::unused_rows;
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;

/// Relative singular value of a direction that the columns do not see.
const UNSEEN: f64 = 1e-6;

/// What a fit of base and chosen columns leaves.
pub struct Fit {
    /// Readings with the outliers replaced by their prediction.
    pub readings: DVector<f64>,
    /// Root mean square of the residual without outliers, mm.
    pub rms_mm: f64,
}

impl Scan<'_> {
    /// Least squares of base and `chosen` (column × row) without outliers.
    pub fn fit(&self, chosen: &DMatrix<f64>) -> Fit {
        let design = stacked(&self.base, chosen).transpose();
        let fit = |used: &[bool]| Ok::<_, Infallible>(self.residual(&design, used));
        let Ok((used, residual)) = excluded(&self.experiment, fit, |residual| residual);
        let mut readings = self.readings.clone();
        let (mut sum, mut count) = (0.0, 0);
        for (point, used) in used.into_iter().enumerate() {
            for row in self.experiment.rows_of(point) {
                if used {
                    sum += (residual[row] / self.root[row]).powi(2);
                    count += 1;
                } else {
                    readings[row] -= residual[row];
                }
            }
        }
        Fit { readings, rms_mm: (sum / f64::from(count.max(1))).sqrt() }
    }

    /// What `design` leaves of all readings, fitted to the points used.
    fn residual(&self, design: &DMatrix<f64>, used: &[bool]) -> DVector<f64> {
        let (mut masked, mut readings) = (design.clone(), self.readings.clone());
        for row in unused_rows(&self.experiment, used) {
            masked.row_mut(row).fill(0.0);
            readings[row] = 0.0;
        }
        let seen = Reduced::from_design(&masked).orthonormal(UNSEEN);
        let values = &seen * (&masked * &seen).tr_mul(&readings);
        &self.readings - design * values
    }
}
