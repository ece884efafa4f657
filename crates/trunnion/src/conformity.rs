//! The largest deviation of a run against a tolerance.
//!
//! E = max |d|    d deviation of the tool against the table at a point, as far as the instrument sees it
//! As measured: what a nominal machine leaves of the readings once the settings are fitted. Corrected: what remains with a correction of
//! everything that tables of the axes can hold (`correction::shown`): what the control would be given, and not what the model explains.
//! E is of the points in the fit, whatever the tolerance; those excluded from it stand next to it (`trunnion_results::Judged`).
//! u(E) is the scatter of a reading about the model. The maximum of many readings lies above the largest true deviation: E errs
//! against the machine.

use crate::correction::Shown;
use crate::values::reading_mm;
use crate::{Error, Fit};
use trunnion_core::convert::um_from_mm;
use trunnion_results::number::{degrees, trimmed};
use trunnion_results::{Conformity, ExcludedPoints, Judged};

impl Fit {
    /// Pass or fail of these runs against a tolerance; `tolerance_of` says where that is from.
    ///
    /// # Errors
    /// When the settings alone cannot be fitted.
    pub fn conformity(&self, tolerance_um: f64, tolerance_of: &str) -> Result<Conformity, Error> {
        let correctable = self.correctable()?;
        let errors = if correctable.why.is_empty() { self.axis_errors()? } else { Default::default() };
        let shown = Shown::new(self, self.experiment(), &errors, &errors)?;
        let judged = |share: f64| self.judged(&shown.sizes_mm(share)).decided(tolerance_um);
        Ok(Conformity {
            tolerance_um,
            tolerance_of: tolerance_of.into(),
            as_measured: judged(0.0),
            corrected: judged(-1.0),
            not_corrected: correctable.left_out,
            why_not_corrected: correctable.why,
        })
    }

    /// Deviations of these sizes, point by point, not yet decided.
    pub(crate) fn judged(&self, sizes_mm: &[f64]) -> Judged {
        let fitted = self.identification();
        let largest = |is_used: bool| {
            let of = |(i, _): &(usize, &f64)| fitted.used[*i] == is_used;
            sizes_mm.iter().enumerate().filter(of).max_by(|a, b| a.1.total_cmp(b.1))
        };
        let excluded = largest(false).map(|(at, size_mm)| ExcludedPoints {
            count: fitted.used.iter().filter(|used| !**used).count(),
            largest_um: um_from_mm(*size_mm),
            at: self.place(at),
        });
        let (largest_um, at) = largest(true)
            .map_or((0.0, String::new()), |(at, size_mm)| (um_from_mm(*size_mm), self.place(at)));
        Judged { largest_um, u_um: um_from_mm(reading_mm(fitted)), at, excluded, ..Judged::default() }
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
