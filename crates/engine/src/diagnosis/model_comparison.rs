//! Comparison of the catalogue with the open grammar, each at its best shape, the noise learned with each (docs/design/statistics.md §4.3).
//!
//! A term wins only when it leads clearly, when no named effect fits as well (the term is then a part of it at a lower price), and
//! when no two named effects together do better.

use crate::diagnosis::expressions::best_term;
use crate::diagnosis::named::{named, price_ln};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::Scored;
use crate::diagnosis::view::{View, What};
use crate::diagnosis::views::{Seen, Views};
use crate::evidence::joined;

/// A term beats the catalogue when it leads by more than this: what would suffice for a claim
/// [docs/decisions/0002-thresholds-of-model-comparison.md].
const CLEAR_LEAD_LN: f64 = 3.0;
/// A named effect that fits as well as the term, up to this, is the plainer explanation of the same shape [ibid.].
const SAME_FIT_LN: f64 = 3.0;
/// Share of a term's gain at which a natural motion accounts for it.
const MOSTLY: f64 = 0.6;
/// Named effects that are tried as the first of two.
const FIRST_OF_TWO: usize = 2;

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
    if term.item.ln_odds <= best.item.ln_odds + CLEAR_LEAD_LN {
        return Some(best);
    }
    let covers = |scored: &&Scored| scored.noticeable && scored.fit_ln > term.fit_ln - SAME_FIT_LN;
    if let Some(covering) = named.iter().find(covers) {
        return Some(covering.clone());
    }
    two_do_better(scan, views, view, named, taken, &term).or(Some(term))
}

/// ln odds on the grid that a term must come near to be looked at, at the learned and at the quiet noise: those of the best named effect.
fn beat(scan: &Scan<'_>, view: &View, best: Option<&Scored>, claim_ln: f64) -> [f64; 2] {
    let group = best.and_then(|best| match best.item.what {
        What::Named(group) if best.item.ln_odds > claim_ln => Some(group),
        _ => None,
    });
    group.map_or([claim_ln; 2], |group| {
        let score = &view.named[group];
        [score.ln_bf, score.quiet_ln_bf].map(|ln_bf| (ln_bf - price_ln(scan, group)).max(claim_ln))
    })
}

/// True where a repeatable motion that is too small to be claimed does most of what the term does.
fn is_natural(named: &[Scored], term: &Scored) -> bool {
    named.iter().any(|scored| !scored.noticeable && scored.fit_ln > MOSTLY * term.fit_ln)
}

/// The first of two named effects that together beat the term and whatever goes best with it.
fn two_do_better(
    scan: &Scan<'_>,
    views: &Views,
    view: &View,
    named: &[Scored],
    taken: &[usize],
    term: &Scored,
) -> Option<Scored> {
    let second = |first: &Scored, also: Option<usize>| {
        let chosen = joined(&view.chosen, &first.item.columns);
        let next = views.of(scan, chosen, &first.sigma);
        let price = (scan.named.len() as f64).ln();
        let free = |g: &usize| !taken.contains(g) && also != Some(*g);
        next.map_or(0.0, |next| {
            (0..scan.named.len())
                .filter(free)
                .map(|g| next.named[g].ln_bf - price - scan.named[g].price_ln)
                .fold(0.0, f64::max)
        })
    };
    let with_term = term.item.ln_odds + second(term, None);
    let candidates = named.iter().filter(|scored| scored.noticeable).take(FIRST_OF_TWO);
    let pairs = candidates.map(|first| {
        let What::Named(group) = first.item.what else { return (f64::NEG_INFINITY, first) };
        let next = second(first, Some(group));
        (if next > 0.0 { first.item.ln_odds + next } else { f64::NEG_INFINITY }, first)
    });
    let (both, first) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (both > with_term).then(|| first.clone())
}
