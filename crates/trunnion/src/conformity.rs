//! The largest deviation of a run against a tolerance.
//!
//! E = max |d|    d deviation of the tool against the table at a point, as far as the instrument sees it
//! As measured: what a nominal machine leaves of the readings once the settings are fitted. Corrected: what the model leaves.
//! Where the others pass, a reading that was left out of the fit and is not within the tolerance leaves it undecided.
//! u(E) is the scatter of a reading about the model. The maximum of many readings lies above the largest true deviation: E errs
//! against the machine.

use crate::values::reading_mm;
use crate::{Error, Fit, prediction};
use nalgebra::DVector;
use trunnion_core::convert::um_from_mm;
use trunnion_results::number::{degrees, trimmed};
use trunnion_results::{Conformity, Decision, Judged};

impl Fit {
    /// Pass or fail of these runs against a tolerance; `tolerance_of` says where that is from.
    ///
    /// # Errors
    /// When the settings alone cannot be fitted.
    pub fn conformity(&self, tolerance_um: f64, tolerance_of: &str) -> Result<Conformity, Error> {
        let nominal = prediction::without_model(self.model().entries(), self.experiment().points())?;
        Ok(Conformity {
            tolerance_um,
            tolerance_of: tolerance_of.into(),
            as_measured: self.judged(&nominal, tolerance_um),
            corrected: self.judged(&self.identification().residual_mm, tolerance_um),
        })
    }

    fn judged(&self, deviation_mm: &DVector<f64>, tolerance_um: f64) -> Judged {
        let (points, fitted) = (self.experiment().points(), self.identification());
        let size_mm = |i: usize| deviation_mm.rows_range(points.rows_of(i)).norm();
        let u_um = um_from_mm(reading_mm(fitted));
        let judged = |of: &dyn Fn(&usize) -> bool| {
            let sizes = (0..points.points.len()).filter(of).map(|i| (i, um_from_mm(size_mm(i))));
            let (at, largest_um) = sizes.max_by(|a, b| a.1.total_cmp(&b.1))?;
            let decision = Decision::of(largest_um, u_um, tolerance_um);
            Some(Judged { largest_um, u_um, at: self.place(at), decision })
        };
        let of_fit = judged(&|i| fitted.used[*i]).unwrap_or_default();
        // One wrong reading fails no machine, and hides no deviation either: the pose is to be read again.
        let left_out = judged(&|i| !fitted.used[*i]).filter(|of| of.decision != Decision::Pass);
        match left_out.filter(|_| of_fit.decision == Decision::Pass) {
            Some(judged) => {
                let at = format!("{}, a reading that was left out of the fit", judged.at);
                Judged { at, decision: Decision::NotDecidable, ..judged }
            }
            None => of_fit,
        }
    }

    /// Setup and position of a point.
    fn place(&self, point: usize) -> String {
        let points = self.experiment().points();
        let state = &points.points[point].state;
        let position = |joint: trunnion_core::Joint| match joint.is_rotary() {
            true => format!("{joint} {}", degrees(state.position[joint])),
            false => format!("{joint} {} mm", trimmed(state.position[joint], 2)),
        };
        let positions: Vec<String> = points.machine().joints().into_iter().map(position).collect();
        let setup = points.setups.get(state.setup).map_or("", |setup| setup.name.as_str());
        format!("setup {setup}, {}", positions.join(", "))
    }
}
