//! Positioning of a linear axis by a laser along it: the values of ISO 230-2 from repeated approaches in a file.
//!
//! x_ij deviation at target i in approach j of n, by direction ↑ ↓; x̄ its mean, s its standard deviation (n − 1):
//!     B_i = x̄_i↑ − x̄_i↓, B = max |B_i| · R_i↑ = 4 s_i↑, R_i = max(2 s_i↑ + 2 s_i↓ + |B_i|, R_i↑, R_i↓), R = max R_i
//!     E = max(x̄↑, x̄↓) − min(x̄↑, x̄↓) · M = max x̄_i − min x̄_i, x̄_i = ½ (x̄_i↑ + x̄_i↓)
//!     A = max(x̄↑ + 2 s↑, x̄↓ + 2 s↓) − min(x̄↑ − 2 s↑, x̄↓ − 2 s↓)
//! and R, E, A of each direction alone [ISO 230-2:2014 clause 3]. A reading gives x = ± (reading − reading of the nominal machine), + where the
//! reading grows with the position. The zero of the display is arbitrary: all values are differences.
//! Uncertainties are those of means and standard deviations of n approaches: u(x̄) = s/√n, u(s) = s/√(2(n − 1)).
//! The direction of an approach is the stated one, or that from the position before; where the axis had not moved and nobody stated it, the reading is left out.
//! Readings that a fit of the base model excludes as single wrong ones count in no value, and are named.
//! Limits: a target that is reached from one side alone, as at the ends of a cycle without overrun, counts for that side, and is named; the axis alone moves; the tilt of the beam (cosine error), air and material temperature are in no value; a largest value grows with the
//! number of targets.

mod report;
mod targets;

use super::{Method, MethodError, MethodOptions, one_machine};
use crate::Findings;
use crate::common::lone;
use targets::recognised;
use trunnion_cycles::Run;

pub(super) static METHOD: Method = Method {
    name: "positioning",
    title: "Positioning of linear axes: accuracy and repeatability by ISO 230-2",
    source: "ISO 230-2:2014",
    about: "A laser along one linear axis while it visits targets again and again from both sides: reversal value, repeatability, systematic \
            deviation and accuracy, each with its uncertainty.",
    takes_axis: false,
    takes_convention: false,
    needs: "an interferometer along one linear axis (instrument diagonal, direction along the axis), which alone moves and visits targets at least \
            twice from one side; five times from both is what ISO 230-2 asks",
    gives: "B, mean reversal, R, E, M, A, and R, E, A of each direction; deviations at every target",
    run,
};

fn run(runs: &[Run], _: &MethodOptions) -> Result<Findings, MethodError> {
    one_machine(runs)?;
    let (kept, outliers) = lone::without_outliers(runs);
    let traces = recognised(&METHOD, &kept)?;
    Ok(lone::named(report::findings(&METHOD, runs, &traces), &outliers, runs, "ISO 230-2"))
}
