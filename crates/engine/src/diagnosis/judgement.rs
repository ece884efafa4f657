//! The verdict where nothing is claimed: an all-clear that is earned, or that these data cannot say.
//!
//! An all-clear needs repeats that show the repeatability, a residual and a held-out error no larger than they allow, no pattern that comes
//! back and is larger than the repeatability of a single reading, no jumps from stop to stop larger than natural, and no effect that has
//! anything to say for it. It states the size of effect that would have been noticed.

use crate::diagnosis::judged::{LearnedNoise, Verdict};
use crate::diagnosis::named::{BARE_MENTION_LN, price_ln};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::search::Found;
use crate::diagnosis::verdict::NextCycle;
use crate::diagnosis::view::What;
use crate::evidence::{off, turned};
use crate::fit::identification::{Identification, Repeatability};
use crate::noise::learned::kernel::{Kernel, Part};
use crate::noise::learned::mode::Mode;
use crate::noise::machine_noise::Order;
use crate::problem::experiment::Experiment;
use nalgebra::DMatrix;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::um;
use trunnion_core::statistics::quantile;

/// Every machine has repeatable motions; up to this times the noise of a single reading they are no finding.
const NATURAL_PATTERN: f64 = 1.5;
/// The larger part: share of what exceeds the repeatability that must come back, or wander, to be what makes it up, and of a residual
/// without repeats that what was found must explain.
const LARGER_PART: f64 = 0.5;
/// An effect is noticed in half of the cases where ½ z² reaches its price, almost always at 1.4 times that.
const ALMOST_ALWAYS: f64 = 1.4;
/// Share of the visible effects that the stated size holds for; what the learned noise nearly hides is not usual.
const MOST_EFFECTS: f64 = 0.8;
/// Directions of the parameters of an effect that the model imitates but for so little, of mean square, are not seen.
const IMITATED: f64 = 1e-6;
/// Usual size of an effect over the white noise: the lower median of the eight sizes that every effect is weighed at
/// [docs/decisions/0002-thresholds-of-model-comparison.md]. At half or double of it the size that would have been noticed changes by 3 to
/// 7 %: ½ ln 4 for each direction in a price of 11 (one direction) to 31 (six).
const PRICE_OF_SIZE: f64 = 2.0;

pub fn noise_sizes(scan: &Scan<'_>, noise: &Mode) -> LearnedNoise {
    let of = |part: Part| size_um(scan, noise, |kernel| kernel.part == part);
    LearnedNoise {
        white_um: um_from_mm(noise.white() * scan.remainder.unit_mm),
        passes_um: of(Part::Pass),
        stations_um: of(Part::Station),
        drift_um: of(Part::Drift),
        pattern_um: of(Part::Pattern),
    }
}

/// Of some kernels together.
fn size_um(scan: &Scan<'_>, noise: &Mode, is_one: impl Fn(&Kernel) -> bool) -> f64 {
    let own = scan.remainder.kernels.list.iter().zip(&noise.x()[1..]).filter(|(kernel, _)| is_one(kernel));
    let size = own.map(|(_, ln)| (2.0 * ln).exp()).sum::<f64>().sqrt();
    um_from_mm(noise.s() * size * scan.remainder.unit_mm)
}

/// Verdict, its reason and what to measure where nothing is claimed.
pub fn nothing_claimed(scan: &Scan<'_>, fit: &Identification, found: &Found) -> (Verdict, String, String) {
    let undecided = |why: String, next: &str| (Verdict::Undecided, why, next.to_string());
    let open: Vec<String> = open_effects(scan, found).map(|(g, _)| scan.named[g].instance.id()).collect();
    let speaks = format!(
        "Something speaks for {}, but no more than offsets of passes and small patterns may do.",
        open.join(", ")
    );
    let repeat = NextCycle::repeat(scan.remainder.rows.whole()).suggestion;
    let Some(repeatability) = fit.known_repeatability() else {
        let why = "Too few poses were measured twice, so the repeatability is not known.";
        let why = if open.is_empty() { why.to_string() } else { format!("{speaks} {why}") };
        return undecided(why, &repeat);
    };
    if !open.is_empty() {
        return undecided(
            speaks,
            "Repeat this pass, twice if time allows, with the setup mounted again between.",
        );
    }
    let (rms_um, noise_um) = (um_from_mm(fit.rms_mm), um_from_mm(repeatability.sigma_mm));
    let sizes = noise_sizes(scan, &found.last.null);
    if comes_back(sizes.pattern_um, repeatability) {
        return pattern(sizes.pattern_um, noise_um);
    }
    // Repeats have these too, so no residual is too large for them; yet what has moved between two stops, whatever angle the axis stops at, and
    // keeps still at each, is no noise of readings.
    let jumps_um = size_um(scan, &found.last.null, Kernel::is_station_of_readings);
    if jumps_um > natural_um(scan, sizes.white_um) {
        return jumps(scan.remainder.rows.whole(), jumps_um, sizes.white_um);
    }
    match (repeatability.allows(fit.rms_mm), units_differ(fit)) {
        (true, None) => return (Verdict::NoiseFloor, String::new(), String::new()),
        (true, Some(why)) => return undecided(why, &repeat),
        (false, _) => {}
    }
    let excess = rms_um.powi(2) - noise_um.powi(2);
    // What looks white next to all kernels and yet comes back in repeats is a pattern finer than they are.
    let fine = (sizes.white_um.powi(2) - noise_um.powi(2)).max(0.0);
    let square_of_pattern = sizes.pattern_um.powi(2) + fine;
    let larger = format!("The residual, {}, is larger than repeats allow ({}).", um(rms_um), um(noise_um));
    if square_of_pattern > LARGER_PART * excess {
        if comes_back(square_of_pattern.sqrt(), repeatability) {
            return pattern(square_of_pattern.sqrt(), noise_um);
        }
        let single_um = um_from_mm(repeatability.single_mm());
        let why = format!(
            "{larger} Most of it is a pattern that comes back, no larger than the noise of a single reading ({}): every \
             machine has such motions. No effect explains it.",
            um(single_um)
        );
        return undecided(why, &repeat);
    }
    let wanders = sizes.passes_um.powi(2) + sizes.stations_um.powi(2) + sizes.drift_um.powi(2);
    if square_of_pattern + wanders > LARGER_PART * excess {
        let why =
            format!("{larger} It wanders with time or differs from pass to pass. No effect explains it.");
        return undecided(why, "Repeat this pass after the machine has run warm, without a pause.");
    }
    // Repeats exclude single differences that are far; what a fit keeps of them is no pattern and does not wander.
    let why = format!(
        "{larger} Single readings, or a few in a row, scatter more than the others. No effect explains it."
    );
    undecided(why, "Look for what disturbed these readings, then repeat this pass.")
}

/// A pattern that no name and no expression describes.
fn pattern(pattern_um: f64, noise_um: f64) -> (Verdict, String, String) {
    let why = format!(
        "A pattern over the positions of some {} comes back in repeats (repeatability {}). No effect or \
         expression describes it.",
        um(pattern_um),
        um(noise_um)
    );
    let next = "Measure the same positions with half the step: a finer grid shows the form of the pattern.";
    (Verdict::UnnamedStructure, why, next.into())
}

/// Something that takes a new place at every stop.
fn jumps(experiment: &Experiment, jumps_um: f64, white_um: f64) -> (Verdict, String, String) {
    let of_axis = Order::new(experiment).slow.map_or(String::new(), |axis| format!(" of {axis}"));
    let why = format!(
        "From stop to stop{of_axis} the readings jump by some {}, where those of one stop scatter by {}: something takes a new \
         place each time. No effect or expression describes it.",
        um(jumps_um),
        um(white_um)
    );
    let next =
        "Look at the seats of ball, nest and probes and at the clamping of the axes, then repeat this pass.";
    (Verdict::UnnamedStructure, why, next.into())
}

/// Size up to which what comes back, or differs from stop to stop, is natural.
fn natural_um(scan: &Scan<'_>, white_um: f64) -> f64 {
    NATURAL_PATTERN * white_um * scan.remainder.kernels.single
}

/// True where a pattern of this size is larger than what differs from visit to visit. More than half of the mean square is then no noise, and
/// the same in the next run; a residual says nothing of it, as what wanders is in it too. Averaging makes the noise smaller and the
/// machine's natural motions not: what is natural is stated against a single reading [docs/design/statistics.md §1.1].
fn comes_back(pattern_um: f64, repeatability: Repeatability) -> bool {
    pattern_um > um_from_mm(repeatability.single_mm())
}

/// Why a fit leaves more than noise although its residual is no larger than repeats allow: what was left out is what the user meets next,
/// and noise that no pass predicts of another is no all-clear.
pub fn units_differ(fit: &Identification) -> Option<String> {
    let repeatability = fit.known_repeatability()?;
    let held_out = fit.holdout.filter(|held_out| !repeatability.allows(held_out.rms_mm))?;
    Some(format!(
        "The {} differ: one left out of the fit is predicted to {} only, where readings repeat to {}. Backlash, a slip of the \
         setup and an offset may be confounded in these data.",
        held_out.left_out.plural(),
        um(um_from_mm(held_out.rms_mm)),
        um(um_from_mm(repeatability.sigma_mm))
    ))
}

/// Why what is left of the residual of `fit` may be more than noise.
pub fn more_than_noise(fit: &Identification, left_mm: f64) -> Option<&'static str> {
    match fit.repeatability {
        Some(noise) if noise.allows(left_mm) => None,
        Some(_) => Some("more is left than visits of one pose differ by"),
        None => is_noise_unknown(fit, left_mm).then_some(
            "most of the residual is left, and no pose was measured twice, which would show whether that is noise",
        ),
    }
}

/// Where no repeat says what noise is, only what takes the larger part of the mean square away shows that it was no noise.
pub fn is_noise_unknown(fit: &Identification, left_mm: f64) -> bool {
    fit.repeatability.is_none() && left_mm.powi(2) > LARGER_PART * fit.rms_mm.powi(2)
}

/// True where the pattern that remains next to all that was found, and the scatter from stop to stop, are no larger than natural: what an
/// effect without a name does at every stop of an axis looks like either. Never where the model with all of it would get no all-clear.
pub fn remainder_is_natural(scan: &Scan<'_>, fit: &Identification, found: &Found) -> bool {
    let sizes = noise_sizes(scan, &found.last.null);
    let comes_back = |known| comes_back(sizes.pattern_um, known);
    sizes.pattern_um.max(sizes.stations_um) <= natural_um(scan, sizes.white_um)
        && !fit.known_repeatability().is_some_and(comes_back)
}

/// Effects with something to say for them that is worth more than a bare mention, where together they are worth more than that.
/// Not the small repeatable motions that every bearing, encoder and gear has: something always speaks for them, and one that is too
/// small to be named is no finding.
pub fn open_effects<'a>(scan: &'a Scan<'_>, found: &'a Found) -> impl Iterator<Item = (usize, f64)> + 'a {
    let is_open = any_effect_ln(scan, found) > BARE_MENTION_LN;
    let open = found.open.iter().copied().filter(move |_| is_open);
    open.filter(|(group, ln_bf)| *ln_bf > BARE_MENTION_LN && !scan.named[*group].natural)
}

/// ln Bayes factor of "one more effect that has a name, whichever" against none: the mean over the names with their priors. Of some
/// forty names the best has a bare mention to say for it by chance in most runs.
fn any_effect_ln(scan: &Scan<'_>, found: &Found) -> f64 {
    let is_in = |group: usize| found.items.iter().any(|item| item.what == What::Named(group));
    let ln_bf = |group: usize| {
        let open_ln = found.open.iter().find(|(open, _)| *open == group).map(|(_, ln_bf)| *ln_bf);
        open_ln.unwrap_or(found.last.named[group].ln_bf)
    };
    let counts = |group: &usize| !scan.named[*group].natural && !is_in(*group);
    let terms =
        (0..scan.named.len()).filter(counts).map(|group| (ln_bf(group) - price_ln(scan, group)).exp());
    terms.sum::<f64>().ln()
}

/// The size of a usual effect that would almost always have been noticed, µm rms of what the model leaves of it: what [`MOST_EFFECTS`] of the
/// visible effects reach in the direction of their parameters that is seen worst. ½ z² must reach the price of the name and of its size.
pub fn noticeable_um(scan: &Scan<'_>, found: &Found, claim_ln: f64) -> Option<f64> {
    let here = &found.last.null.here;
    let basis = found.last.basis.map(f64::from);
    let white = found.last.null.white();
    let sizes: Vec<f64> = scan
        .named
        .iter()
        .zip(&found.last.named)
        .filter(|(_, score)| score.visible)
        .filter_map(|(named, _)| {
            let part = (named.parts.start + named.parts.end) / 2;
            let columns = scan.part(part);
            if columns.is_empty() {
                return None;
            }
            let left = off(&columns, &basis);
            let seen = left.tr_mul(&left) / columns.nrows() as f64;
            let single: DMatrix<crate::noise::learned::Real> = turned(&columns).cast();
            let gram = here.grams(&single, &[single.ncols()]).remove(0);
            let eigen = ((&gram + gram.transpose()) * 0.5).symmetric_eigenvalues();
            let of_size: f64 =
                eigen.iter().map(|l| 0.5 * ((PRICE_OF_SIZE * white).powi(2) * l.max(0.0)).ln_1p()).sum();
            let price = (scan.named.len() as f64).ln() + claim_ln + of_size;
            let information = least_ratio(&gram, &seen)?;
            (information > 0.0).then(|| (2.0 * price / information).sqrt())
        })
        .collect();
    quantile(&sizes, MOST_EFFECTS).map(|size| um_from_mm(ALMOST_ALWAYS * size * scan.remainder.unit_mm))
}

/// The least information, over the directions of the parameters of an effect, that a unit of mean square left in the readings gives.
fn least_ratio(gram: &DMatrix<f64>, seen: &DMatrix<f64>) -> Option<f64> {
    let seen = seen.clone().symmetric_eigen();
    let most = seen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let kept: Vec<usize> =
        (0..seen.eigenvalues.len()).filter(|&k| seen.eigenvalues[k] > IMITATED * most).collect();
    let unit = DMatrix::from_fn(seen.eigenvectors.nrows(), kept.len(), |i, k| {
        seen.eigenvectors[(i, kept[k])] / seen.eigenvalues[kept[k]].sqrt()
    });
    let information = unit.tr_mul(&(gram * &unit));
    let symmetric = (&information + information.transpose()) * 0.5;
    symmetric.symmetric_eigenvalues().iter().copied().reduce(f64::min)
}
