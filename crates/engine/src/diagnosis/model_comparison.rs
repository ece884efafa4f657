//! Comparison of the catalogue with the open grammar, each at its best shape (docs/design/statistics.md §4.3).
//!
//! A term wins only when it leads clearly, when no named effect fits as well (the term is then a part of it at a lower price), and
//! when no two named effects together do better.

use crate::diagnosis::expressions::best_term;
use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{NAMED_WITHIN_LN, SHAPE_MAY_ADD_LN, Scored, shape_price_ln, term_price_ln};
use crate::diagnosis::view::{Item, View, What};
use crate::evidence::{Natural, Score, stacked};
use nalgebra::DMatrix;

/// Named effects that are brought to their best shape, at most.
const NAMED_FINALISTS: usize = 4;
/// A term beats the catalogue when it leads by more than this.
const CLEAR_LEAD_LN: f64 = 3.0;
/// A named effect that fits as well as the term, up to this, is the plainer explanation of the same shape.
const SAME_FIT_LN: f64 = 3.0;
/// Share of a term's gain at which a natural motion accounts for it.
const MOSTLY: f64 = 0.6;
/// Named effects that are tried as the first of two.
const FIRST_OF_TWO: usize = 3;

/// The best addition, if any is worth claiming; `taken` are named effects that are in already.
pub fn best_addition(scan: &Scan<'_>, view: &View, taken: &[usize], claim_ln: f64) -> Option<Item> {
    let named = named(scan, view, taken, claim_ln);
    let beat = named.first().map_or(claim_ln, |best| best.item.ln_odds);
    let term = best_term(scan, view, beat)
        .filter(|term| term.item.ln_odds > claim_ln && !is_natural(scan, view, term));
    let (best, term) = match (named.first(), term) {
        (best, None) => return best.map(|best| best.item.clone()),
        (None, Some(term)) => return Some(term.item),
        (Some(best), Some(term)) => (best, term),
    };
    if term.item.ln_odds <= best.item.ln_odds + CLEAR_LEAD_LN {
        return Some(best.item.clone());
    }
    let covers = |scored: &&Scored| scored.score.fit_ln > term.score.fit_ln - SAME_FIT_LN;
    if let Some(covering) = named.iter().find(covers) {
        return Some(covering.item.clone());
    }
    two_do_better(scan, view, &named, taken, &term, claim_ln).or(Some(term.item))
}

/// True where a repeatable motion that is too small to be claimed does most of what the term does.
fn is_natural(scan: &Scan<'_>, view: &View, term: &Scored) -> bool {
    let scores = view.named.iter().zip(&scan.named.groups);
    let too_small =
        scores.filter(|(score, group)| group.natural != Natural::No && score.ln_odds == f64::NEG_INFINITY);
    let nothing = view.situation.nothing.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let most = MOSTLY * (term.score.fit_ln - nothing);
    too_small.into_iter().any(|(score, _)| score.fit_ln - nothing > most)
}

/// Named effects worth claiming, best first, at their best shapes.
fn named(scan: &Scan<'_>, view: &View, taken: &[usize], claim_ln: f64) -> Vec<Scored> {
    let scores = &view.named;
    let mut order: Vec<usize> = (0..scores.len())
        .filter(|g| !taken.contains(g) && scores[*g].ln_odds > claim_ln - SHAPE_MAY_ADD_LN)
        .collect();
    order.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
    let best = order.first().map_or(0.0, |&g| scores[g].ln_odds);
    order.retain(|&g| scores[g].ln_odds > best - NAMED_WITHIN_LN);
    order.truncate(NAMED_FINALISTS);
    let mut scored: Vec<Scored> = order.into_iter().map(|g| shaped_named(scan, view, g)).collect();
    scored.retain(|scored| scored.item.ln_odds > claim_ln);
    scored.sort_by(|a, b| b.item.ln_odds.total_cmp(&a.item.ln_odds));
    scored
}

/// A named effect at its best shape in a view.
pub fn named_item(scan: &Scan<'_>, view: &View, group: usize) -> Item {
    shaped_named(scan, view, group).item
}

fn shaped_named(scan: &Scan<'_>, view: &View, group: usize) -> Scored {
    let score = view.named[group];
    let shapes = &scan.shapes[group];
    let shape = shapes.grid[score.part].clone();
    let columns = scan.named.part(group, score.part).transpose();
    let on_grid =
        Scored { item: Item { what: What::Named(group), shape, columns, ln_odds: score.ln_odds }, score };
    if !shapes.continuous || shapes.grid.len() < 2 || score.surviving == 0 {
        return on_grid;
    }
    let gain_ln =
        |columns: &DMatrix<f64>| scan.bank.gain_ln(columns, score.member, score.motion, &view.situation);
    let columns = |shape: &[f64]| {
        let columns = scan.columns(&scan.instances[group], shape);
        columns.iter().all(|x| x.is_finite()).then_some(columns)
    };
    let Item { shape, columns: first, .. } = on_grid.item.clone();
    let within = stretches(&shapes.grid, &shape, None);
    let start = Shaped { gain_ln: gain_ln(&first), shape, columns: first };
    let Shaped { shape, columns, .. } = refined(start, &within, columns, gain_ln);
    let group_of = &scan.named.groups[group];
    let prior_ln = group_of.prior_ln - shape_price_ln(shapes.grid.len(), &shape);
    let all = scan.bank.all();
    let at_best = scan.bank.weigh(&columns, prior_ln, group_of.natural, &all, &view.situation);
    let ln_odds = at_best.ln_odds.max(score.ln_odds);
    let item = Item { what: What::Named(group), shape, columns, ln_odds };
    Scored { item, score: Score { ln_odds, part: score.part, ..at_best } }
}

/// ln odds of an item as it is in another view, and how much they must be beaten by: a plainer explanation may cost a little.
pub fn ln_odds_required(scan: &Scan<'_>, view: &View, item: &Item, by: &Item) -> f64 {
    let (prior_ln, natural) = match &item.what {
        What::Named(group) => {
            let group_of = &scan.named.groups[*group];
            (
                group_of.prior_ln - shape_price_ln(scan.shapes[*group].grid.len(), &item.shape),
                group_of.natural,
            )
        }
        What::Open(term) => {
            (-term_price_ln(scan, term, &item.shape), scan.vocabulary.families[term.family].natural)
        }
    };
    let all = scan.bank.all();
    let now = scan.bank.weigh(&item.columns, prior_ln, natural, &all, &view.situation).ln_odds;
    if item.is_open() && !by.is_open() { now - CLEAR_LEAD_LN } else { now }
}

/// The first of two named effects that together beat the term and whatever goes best with it.
fn two_do_better(
    scan: &Scan<'_>,
    view: &View,
    named: &[Scored],
    taken: &[usize],
    term: &Scored,
    claim_ln: f64,
) -> Option<Item> {
    let next_to = |item: &Item| view.with(scan, item);
    let best_named = |view: &View, also: Option<usize>| {
        let scores = view.named.iter().enumerate();
        let free = scores.filter(|(g, _)| !taken.contains(g) && also != Some(*g));
        free.map(|(_, score)| score.ln_odds).filter(|ln_odds| *ln_odds > claim_ln).fold(0.0, f64::max)
    };
    let with_term = term.item.ln_odds + best_named(&next_to(&term.item), None);
    let pairs = named.iter().take(FIRST_OF_TWO).map(|first| {
        let What::Named(group) = first.item.what else { return (f64::NEG_INFINITY, first) };
        let second = best_named(&next_to(&first.item), Some(group));
        let both = if second > 0.0 { first.item.ln_odds + second } else { f64::NEG_INFINITY };
        (both, first)
    });
    let (both, first) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (both > with_term).then(|| first.item.clone())
}

impl View {
    /// The same readings with one more item in the model, catalogue scored again.
    fn with(&self, scan: &Scan<'_>, item: &Item) -> Self {
        let chosen = stacked(&self.chosen, &item.columns);
        Self::of(scan, chosen)
    }
}
