//! Comparison of the catalogue with the open grammar, each at its best shape, the noise learned with each (docs/design/statistics.md §4.3).
//!
//! A term wins only when it leads clearly, when no named effect fits as well (the term is then a part of it at a lower price), and
//! when no row of named effects does better.

use crate::diagnosis::expressions::best_term;
use crate::diagnosis::named::{first_named, named, price_ln};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::Scored;
use crate::diagnosis::sparse::sparse_ln_odds;
use crate::diagnosis::view::{View, What};
use crate::diagnosis::views::{Seen, Views};
use crate::evidence::{joined, off, orthonormal};
use crate::noise::learned::sigma::Sigma;
use nalgebra::DMatrix;
use std::f64::consts::TAU;
use std::sync::Arc;
use trunnion_effects::WaveNumber;

/// A term beats the catalogue when it leads by more than this: what would suffice for a claim
/// [docs/decisions/0002-thresholds-of-model-comparison.md].
const CLEAR_LEAD_LN: f64 = 3.0;
/// Share of the columns of a term that those of a name may lack, and hold it: what [`orthonormal`] leaves out.
const SAME_COLUMNS: f64 = 1e-2;
/// A named effect that fits as well as the term, up to this, is the plainer explanation of the same shape [ibid.].
const SAME_FIT_LN: f64 = 3.0;
/// Share of a term's gain at which a natural motion accounts for it.
const MOSTLY: f64 = 0.6;
/// Named effects that are tried as the first of several.
const FIRST_OF_SEVERAL: usize = 2;
/// Named effects that may follow a first one or a term. With the first they are six: squarenesses and scales of three linear axes.
const MOST_FOLLOWING: usize = 5;
/// Of those that could come next in a row, by what they say at the learned noise and in a quiet one, so many have the noise learned with them.
const MOST_AT_ONCE: [usize; 2] = [1, 1];

/// What could be added next.
pub struct Additions {
    /// The best, whether or not it is worth claiming.
    pub best: Option<Scored>,
    /// Named effects with the noise learned with them, best first.
    pub named: Vec<Scored>,
}

/// Looks at everything; `taken` are named effects that are in already.
pub fn additions(scan: &Scan<'_>, views: &Views, view: &Seen, taken: &[usize], claim_ln: f64) -> Additions {
    let named = named(scan, view, taken, claim_ln);
    let best = best(scan, views, view, &named, taken, claim_ln);
    Additions { best, named }
}

fn best(
    scan: &Scan<'_>,
    views: &Views,
    view: &Seen,
    named: &[Scored],
    taken: &[usize],
    claim_ln: f64,
) -> Option<Scored> {
    let best = named.iter().find(|scored| scored.noticeable).cloned();
    let term = best_term(scan, view, beat(scan, view, best.as_ref(), claim_ln))
        .filter(|term| term.noticeable && term.item.ln_odds > claim_ln && !is_natural(named, term));
    let Some(term) = term else { return best };
    let Some(best) = best.filter(|best| best.item.ln_odds > claim_ln) else { return Some(term) };
    if term.item.ln_odds <= sparse_ln_odds(scan, &best, Some(&term.noise)) + CLEAR_LEAD_LN {
        return Some(best);
    }
    let is_claimed = |scored: &&Scored| scored.noticeable && scored.item.ln_odds > claim_ln;
    if let Some(name) = named.iter().filter(is_claimed).find(|name| holds(scan, name, &term)) {
        return Some(name.clone());
    }
    let covers = |scored: &&Scored| scored.noticeable && scored.fit_ln > term.fit_ln - SAME_FIT_LN;
    if let Some(covering) = named.iter().find(covers) {
        return Some(covering.clone());
    }
    several_do_better(scan, views, view, named, taken, &term, claim_ln).or(Some(term))
}

/// Whether the term is the named effect with some of its parameters at zero: at one of its shapes the columns of the name hold those of the term.
/// One of several temperatures, a wave along an axis.
fn holds(scan: &Scan<'_>, name: &Scored, term: &Scored) -> bool {
    let Some(group) = name.item.what.group() else { return false };
    let named = &scan.named[group];
    let of_wave = named.shapes.wave.and_then(|wave| Some(vec![repeats(scan, term, wave)?]));
    let base = orthonormal(&scan.remainder.base);
    let of_term = off(&term.item.columns, &base);
    let is_held = |shape: &Vec<f64>| {
        scan.finite_columns_of(&named.instance, shape).is_some_and(|columns| {
            let own = orthonormal(&off(&columns, &base));
            off(&of_term, &own).norm() <= SAME_COLUMNS * of_term.norm()
        })
    };
    named.shapes.grid.iter().chain([&name.item.shape]).chain(&of_wave).any(is_held)
}

/// The number of a wave along an axis that repeats as the term does.
fn repeats(scan: &Scan<'_>, term: &Scored, wave: WaveNumber) -> Option<f64> {
    let What::Open(open) = &term.item.what else { return None };
    let numbers = &scan.vocabulary.families[open.family].numbers;
    let of_name = |name: &str| Some(term.item.shape[numbers.iter().position(|number| number.name == name)?]);
    match wave {
        WaveNumber::Period(_) => of_name("per_mm").map(|rad_per_mm| TAU / rad_per_mm),
        WaveNumber::Cycles(_) => of_name("cycles"),
    }
}

/// ln odds on the grid that a term must come near to be looked at, at the learned and at the quiet noise: those of the best named effect.
fn beat(scan: &Scan<'_>, view: &View, best: Option<&Scored>, claim_ln: f64) -> [f64; 2] {
    let group = best.filter(|best| best.item.ln_odds > claim_ln).and_then(|best| best.item.what.group());
    group.map_or([claim_ln; 2], |group| {
        let score = &view.named[group];
        [score.ln_bf, score.quiet_ln_bf].map(|ln_bf| (ln_bf - price_ln(scan, group)).max(claim_ln))
    })
}

/// True where a repeatable motion that is too small to be claimed does most of what the term does.
fn is_natural(named: &[Scored], term: &Scored) -> bool {
    named.iter().any(|scored| !scored.noticeable && scored.fit_ln > MOSTLY * term.fit_ln)
}

/// The first of a row of named effects that the term, with whatever named follows it, does not clearly lead. Three squarenesses are no expression
/// because two of them share a coordinate.
fn several_do_better(
    scan: &Scan<'_>,
    views: &Views,
    view: &View,
    named: &[Scored],
    taken: &[usize],
    term: &Scored,
    claim_ln: f64,
) -> Option<Scored> {
    let all_ln = |first: &Scored, enough_ln: f64| {
        let start = Start {
            chosen: joined(&view.chosen, &first.item.columns),
            sigma: first.sigma().clone(),
            taken: taken.iter().copied().chain(first.item.what.group()).collect(),
        };
        let first_ln = sparse_ln_odds(scan, first, Some(&term.noise));
        first_ln + following_ln(scan, views, start, claim_ln, enough_ln - first_ln)
    };
    let enough_ln = all_ln(term, f64::INFINITY) - CLEAR_LEAD_LN;
    let mut candidates = named.iter().filter(|scored| scored.noticeable).take(FIRST_OF_SEVERAL);
    candidates.find(|first| all_ln(first, enough_ln) > enough_ln).cloned()
}

/// Where a row of named effects begins.
struct Start {
    chosen: DMatrix<f64>,
    /// A noise near by.
    sigma: Arc<Sigma>,
    taken: Vec<usize>,
}

/// ln odds of named effects that can be claimed one after the other, best first, up to `enough_ln`.
fn following_ln(scan: &Scan<'_>, views: &Views, start: Start, claim_ln: f64, enough_ln: f64) -> f64 {
    let Start { mut chosen, mut sigma, mut taken } = start;
    let mut sum_ln = 0.0;
    for _ in 0..MOST_FOLLOWING {
        if sum_ln > enough_ln {
            break;
        }
        let Some(view) = views.of(scan, chosen.clone(), &sigma) else { break };
        let scored = first_named(scan, &view, &taken, claim_ln, MOST_AT_ONCE);
        let Some(best) = scored.into_iter().find(|scored| scored.noticeable) else { break };
        if best.item.ln_odds <= claim_ln {
            break;
        }
        sum_ln += sparse_ln_odds(scan, &best, None);
        chosen = joined(&chosen, &best.item.columns);
        taken.extend(best.item.what.group());
        sigma = best.sigma().clone();
    }
    sum_ln
}
