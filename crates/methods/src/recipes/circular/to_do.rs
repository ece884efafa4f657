//! What to do after a circle: where to look for what makes it out of round, largest first, and what to enter into the control.

use super::fit::{Fitted, FittedError};
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::um_or_less;
use trunnion_effects::catalogue::effect;

/// Errors to look for; the tables have all.
const MOST_NAMED: usize = 3;

/// In the order in which it is done; never empty.
pub(super) fn to_do(fits: &[Fitted<'_>]) -> Vec<String> {
    let significant = |fit| -> Vec<(&Fitted<'_>, &FittedError)> {
        let fit: &Fitted<'_> = fit;
        fit.errors.iter().filter(|error| error.significant()).map(|error| (fit, error)).collect()
    };
    let mut errors: Vec<_> = fits.iter().flat_map(significant).collect();
    errors.sort_by(|a, b| b.1.circularity_mm.total_cmp(&a.1.circularity_mm));
    let mut named: Vec<&str> = Vec::new();
    let mut to_do = Vec::new();
    for (fit, error) in &errors {
        // Two planes see one error of an axis.
        let name = error.listed.name.as_str();
        if named.contains(&name) || named.len() == MOST_NAMED {
            continue;
        }
        named.push(name);
        let about = error.listed.kind.phenomenon().and_then(effect).map(|effect| &effect.about);
        let what = about.map_or(name.into(), |about| format!("{} ({name})", about.title));
        let cause = about.map_or(String::new(), |about| format!(" Likely cause: {}", about.cause));
        to_do.push(format!(
            "Look for: {what}. Alone it makes {} of the circle in {}.{cause}",
            um_or_less(um_from_mm(error.circularity_mm)),
            fit.trace.name
        ));
    }
    let enter: Vec<String> = errors.iter().filter_map(|(fit, error)| error.to_enter(fit.trace)).collect();
    if !enter.is_empty() {
        to_do.push(format!(
            "Or enter into the control: {}. Then measure again: a wrong sign doubles the error.",
            enter.join("; ")
        ));
    }
    if errors.is_empty() {
        to_do.push("Change nothing: no error of the list is significant.".into());
    }
    if fits.iter().any(Fitted::leaves_more_than_noise) {
        to_do.push("Ask what the list does not explain: trunnion diagnose with the same runs.".into());
    }
    to_do
}
