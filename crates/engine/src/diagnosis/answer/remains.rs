//! Whether what was found is adequate, and what remains with it.

use super::Context;
use crate::diagnosis::judgement::{more_than_noise, remainder_is_natural, units_differ};
use crate::diagnosis::refits::Refit;
use crate::diagnosis::rivals::CONFUSED_LN;
use crate::diagnosis::view::Item;

impl Context<'_> {
    /// Nothing structured remains with this item alone: it is all that was found, or fits as well as all that was found.
    pub(super) fn adequate(&self, item: &Item) -> bool {
        let all_found = match &self.found.items[..] {
            [only] => only.what == item.what,
            _ => false,
        };
        let like_all_found = || {
            let readings = self.scan.remainder.y.len() as f64;
            readings * (self.scan.left(&item.columns) / self.floor_mm).ln() < CONFUSED_LN
        };
        // A second shape is no part of a model with it.
        self.found.further.ncols() == 0 && self.is_all() && (all_found || like_all_found())
    }

    /// Nothing structured remains with all that was found, and all of it has names.
    fn is_all(&self) -> bool {
        self.is_more().is_empty()
    }

    /// Why there is more than all that was found and has a name.
    fn is_more(&self) -> Vec<&'static str> {
        let asked = [
            (!self.found.complete, "more is significant in it, which was not named"),
            (self.found.items.iter().any(Item::is_open), "a part of it has no name in the catalogue"),
            (!self.is_constant, "one of these effects changes with time or place by more than chance"),
            (
                !remainder_is_natural(self.scan, self.problem.fit(), self.found),
                "at the stops of the axes something comes back that bearings, encoders and gears do not explain",
            ),
        ];
        asked.into_iter().filter(|(holds, _)| *holds).map(|(_, why)| why).collect()
    }

    /// Whether another cause may be behind one of several effects.
    pub(super) fn is_of_another_cause(&self, refit: &Refit) -> bool {
        self.found.items.len() > 1 && refit.is_of_another_cause(self.problem)
    }

    /// Why a part is left with all that was found.
    pub(super) fn what_is_left(&self, refit: &Refit) -> Vec<&'static str> {
        let asked = [
            (
                // The remark on a single one has the figures.
                self.found.items.len() > 1 && units_differ(refit.fit()).is_some(),
                "passes or setups that the fit leaves out are predicted worse than visits of one pose differ by",
            ),
            (
                self.found.further.ncols() > 0,
                "one of these effects is needed with a second shape, and a model holds one",
            ),
        ];
        let of_fit = asked.into_iter().filter(|(holds, _)| *holds).map(|(_, why)| why);
        let noise = more_than_noise(self.problem.fit(), refit.rms_mm());
        noise.into_iter().chain(of_fit).chain(self.is_more()).collect()
    }

    /// Why what was found is not adequate, and what to do; none where it is.
    pub(super) fn what_remains(&self, refit: &Refit) -> Option<String> {
        let of_another_cause = self.is_of_another_cause(refit).then_some(
            "an axis goes one way while time goes on, and an error along it reads the same as one of these effects",
        );
        let reasons: Vec<&str> = self.what_is_left(refit).into_iter().chain(of_another_cause).collect();
        (!reasons.is_empty()).then(|| {
            format!(
                "What was found is not adequate: {}. Add it to the model, then diagnose again.",
                reasons.join("; ")
            )
        })
    }
}
