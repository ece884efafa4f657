//! Mistakes without a number to choose: signs and inputs of probes, and readings that are rows late or early.
//!
//! They cannot follow an effect, as a free angle or gain does. Next to other physics, or of balls set well, undoing one may divide what is left
//! by less than is asked of every mistake: it is named where it explains at least as much as all else, and neither an effect of one axis nor a slip
//! leaves as little. In 250 good runs of the second simulator, with its physics known and unknown, none divided what is left by more than 1.05.

use super::axes::ways;
use super::{CHANGE, GROSS_UM, MOSTLY, Trial, believed, variation_um};
use crate::plausibility::fitted::Tried;
use crate::plausibility::found::Implausible;
use crate::plausibility::looked::Looked;
use trunnion_cycles::RunKind;

pub(in crate::plausibility) fn plain(looked: &Looked) -> Option<Implausible> {
    if variation_um(&looked.run) < GROSS_UM {
        return None;
    }
    believed(looked, MOSTLY, |trial| trial.plain().into_iter().map(|one| (one, CHANGE)).collect())
}

impl Trial<'_> {
    /// Of all readings.
    pub(super) fn plain(&self) -> Vec<Tried> {
        let mut tried = if self.has_three() { self.of_ways() } else { Vec::new() };
        if self.run.kind == RunKind::Static {
            tried.extend(self.shifted(None));
        }
        tried
    }

    /// Signs of probes and inputs of all readings.
    fn of_ways(&self) -> Vec<Tried> {
        let ways = ways();
        let first = ways.iter().filter(|way| way.is_first_of_two());
        first.map(|way| (way.words_of_all(), self.changed_mm(None, |reading| way.apply(reading)))).collect()
    }
}
