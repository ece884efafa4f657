//! The duel of the catalogue with the open grammar, each at its best shape (docs/design/statistics.md §4.3).
//!
//! A phrase wins only when it leads clearly, when no named effect fits as well (the phrase is then a part of it at a lower price), and
//! when no two named effects together do better.

use crate::diagnosis::phrases::{SHAPE_MAY_ADD_LN, phrase, saying_price_ln, shape_price_ln};
use crate::diagnosis::problem::Problem;
use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::search::{Item, View, What};
use crate::evidence::{Natural, Score, stacked};
use nalgebra::DMatrix;

/// Named effects this far behind the best are not brought to their best shape, and how many are at most.
pub const NAMED_WITHIN_LN: f64 = 12.0;
const NAMED_FINALISTS: usize = 4;
/// A phrase beats the catalogue when it leads by more than this.
const CLEAR_LEAD_LN: f64 = 3.0;
/// A named effect that fits as well as the phrase, up to this, is the plainer explanation of the same shape.
const SAME_FIT_LN: f64 = 3.0;
/// Share of a phrase's gain at which a natural motion accounts for it.
const MOSTLY: f64 = 0.6;
/// Named effects that are tried as the first of two.
const FIRST_OF_TWO: usize = 3;

/// One that takes part, at its best shape.
#[derive(Clone)]
pub struct Contender {
    pub item: Item,
    pub score: Score,
}

/// The best addition, if any is worth claiming; `taken` are named effects that are in already.
pub fn winner(problem: &Problem<'_>, view: &View, taken: &[usize], claim_ln: f64) -> Option<Item> {
    let named = named(problem, view, taken, claim_ln);
    let beat = named.first().map_or(claim_ln, |best| best.item.ln_odds);
    let phrase = phrase(problem, view, beat)
        .filter(|phrase| phrase.item.ln_odds > claim_ln && !is_natural(problem, view, phrase));
    let (best, phrase) = match (named.first(), phrase) {
        (best, None) => return best.map(|best| best.item.clone()),
        (None, Some(phrase)) => return Some(phrase.item),
        (Some(best), Some(phrase)) => (best, phrase),
    };
    if phrase.item.ln_odds <= best.item.ln_odds + CLEAR_LEAD_LN {
        return Some(best.item.clone());
    }
    let covers = |contender: &&Contender| contender.score.fit_ln > phrase.score.fit_ln - SAME_FIT_LN;
    if let Some(covering) = named.iter().find(covers) {
        return Some(covering.item.clone());
    }
    two_do_better(problem, view, &named, taken, &phrase, claim_ln).or(Some(phrase.item))
}

/// True where a repeatable motion that is too small to be claimed does most of what the phrase does.
fn is_natural(problem: &Problem<'_>, view: &View, phrase: &Contender) -> bool {
    let scores = view.named.scores.iter().zip(&problem.named.groups);
    let too_small =
        scores.filter(|(score, group)| group.natural != Natural::No && score.ln_odds == f64::NEG_INFINITY);
    let nothing = view.situation.nothing.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let enough = MOSTLY * (phrase.score.fit_ln - nothing);
    too_small.into_iter().any(|(score, _)| score.fit_ln - nothing > enough)
}

/// Named effects worth claiming, best first, at their best shapes.
fn named(problem: &Problem<'_>, view: &View, taken: &[usize], claim_ln: f64) -> Vec<Contender> {
    let scores = &view.named.scores;
    let mut order: Vec<usize> = (0..scores.len())
        .filter(|g| !taken.contains(g) && scores[*g].ln_odds > claim_ln - SHAPE_MAY_ADD_LN)
        .collect();
    order.sort_by(|&a, &b| scores[b].ln_odds.total_cmp(&scores[a].ln_odds));
    let best = order.first().map_or(0.0, |&g| scores[g].ln_odds);
    order.retain(|&g| scores[g].ln_odds > best - NAMED_WITHIN_LN);
    order.truncate(NAMED_FINALISTS);
    let mut contenders: Vec<Contender> = order.into_iter().map(|g| shaped_named(problem, view, g)).collect();
    contenders.retain(|contender| contender.item.ln_odds > claim_ln);
    contenders.sort_by(|a, b| b.item.ln_odds.total_cmp(&a.item.ln_odds));
    contenders
}

/// A named effect at its best shape in a view.
pub fn named_item(problem: &Problem<'_>, view: &View, group: usize) -> Item {
    shaped_named(problem, view, group).item
}

fn shaped_named(problem: &Problem<'_>, view: &View, group: usize) -> Contender {
    let score = view.named.scores[group];
    let shapes = &problem.shapes[group];
    let shape = shapes.grid[score.part].clone();
    let columns = problem.named.part(group, score.part).transpose();
    let on_grid =
        Contender { item: Item { what: What::Named(group), shape, columns, ln_odds: score.ln_odds }, score };
    if !shapes.continuous || shapes.grid.len() < 2 || score.surviving == 0 {
        return on_grid;
    }
    let gain_ln =
        |columns: &DMatrix<f64>| problem.bank.gain_ln(columns, score.member, score.motion, &view.situation);
    let columns = |shape: &[f64]| {
        let columns = problem.columns(&problem.instances[group], shape);
        columns.iter().all(|x| x.is_finite()).then_some(columns)
    };
    let Item { shape, columns: first, .. } = on_grid.item.clone();
    let within = stretches(&shapes.grid, &shape, None);
    let start = Shaped { gain_ln: gain_ln(&first), shape, columns: first };
    let Shaped { shape, columns, .. } = refined(start, &within, columns, gain_ln);
    let group_of = &problem.named.groups[group];
    let prior_ln = group_of.prior_ln - shape_price_ln(shapes.grid.len(), &shape);
    let all = problem.bank.all();
    let at_best = problem.bank.weigh(&columns, prior_ln, group_of.natural, &all, &view.situation);
    let ln_odds = at_best.ln_odds.max(score.ln_odds);
    let item = Item { what: What::Named(group), shape, columns, ln_odds };
    Contender { item, score: Score { ln_odds, part: score.part, ..at_best } }
}

/// ln odds of an item as it is in another view, and how much they must be beaten by: a plainer explanation may cost a little.
pub fn odds_to_beat(problem: &Problem<'_>, view: &View, item: &Item, by: &Item) -> f64 {
    let (prior_ln, natural) = match &item.what {
        What::Named(group) => {
            let group_of = &problem.named.groups[*group];
            (
                group_of.prior_ln - shape_price_ln(problem.shapes[*group].grid.len(), &item.shape),
                group_of.natural,
            )
        }
        What::Open(saying) => (
            -saying_price_ln(problem, saying, &item.shape),
            problem.vocabulary.families[saying.family].natural,
        ),
    };
    let all = problem.bank.all();
    let now = problem.bank.weigh(&item.columns, prior_ln, natural, &all, &view.situation).ln_odds;
    if item.is_open() && !by.is_open() { now - CLEAR_LEAD_LN } else { now }
}

/// The first of two named effects that together beat the phrase and whatever goes best with it.
fn two_do_better(
    problem: &Problem<'_>,
    view: &View,
    named: &[Contender],
    taken: &[usize],
    phrase: &Contender,
    claim_ln: f64,
) -> Option<Item> {
    let beside = |item: &Item| view.with(problem, item);
    let best_named = |view: &View, also: Option<usize>| {
        let scores = view.named.scores.iter().enumerate();
        let free = scores.filter(|(g, _)| !taken.contains(g) && also != Some(*g));
        free.map(|(_, score)| score.ln_odds).filter(|ln_odds| *ln_odds > claim_ln).fold(0.0, f64::max)
    };
    let with_phrase = phrase.item.ln_odds + best_named(&beside(&phrase.item), None);
    let pairs = named.iter().take(FIRST_OF_TWO).map(|first| {
        let What::Named(group) = first.item.what else { return (f64::NEG_INFINITY, first) };
        let second = best_named(&beside(&first.item), Some(group));
        let both = if second > 0.0 { first.item.ln_odds + second } else { f64::NEG_INFINITY };
        (both, first)
    });
    let (both, first) = pairs.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (both > with_phrase).then(|| first.item.clone())
}

impl View {
    /// The same readings with one more item in the model, catalogue scored again.
    fn with(&self, problem: &Problem<'_>, item: &Item) -> Self {
        let chosen = stacked(&self.chosen, &item.columns);
        Self::of(problem, chosen)
    }
}
