//! The duel of the catalogue with the open grammar, each at its best shape (DIAGNOSIS §4).
//!
//! A phrase wins only when it leads clearly, when no named effect fits as well (the phrase is then a part of it at a lower price), and
//! when no two named effects together do better.

use crate::evidence::{Natural, Score, WHITE, stacked};
use crate::problem::Problem;
use crate::refine::{Shaped, refined, stretches};
use crate::search::{Item, View, What};
use crate::vocabulary::{SIBLING_LN, Saying};
use nalgebra::DMatrix;

/// Noise models under which the whole grammar is scored; its best phrases are then scored under all.
const OPEN_MEMBERS: usize = 3;
/// Best phrases of the grammar that are scored under the whole bank.
const OPEN_FINALISTS: usize = 10;
/// Of these, how many are brought to their best shape, with their kin.
const SHAPED_FINALISTS: usize = 3;
/// Of their kin, how many.
const SHAPED_KIN: usize = 3;
/// Named effects this far behind the best are not brought to their best shape, and how many are at most.
const NAMED_WITHIN_LN: f64 = 12.0;
const NAMED_FINALISTS: usize = 4;
/// What the best shape may add to odds on the grid.
const SHAPE_MAY_ADD_LN: f64 = 12.0;
/// Price of each shape number that was brought to its best value, ln.
const NUMBER_LN: f64 = 1.0;
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
struct Contender {
    item: Item,
    score: Score,
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

/// Price of having chosen a shape, ln: one of the grid, then between its points.
fn shape_price_ln(grid: usize, shape: &[f64]) -> f64 {
    (grid.max(1) as f64).ln() + NUMBER_LN * shape.len() as f64
}

fn saying_price_ln(problem: &Problem<'_>, saying: &Saying, shape: &[f64]) -> f64 {
    let vocabulary = &problem.vocabulary;
    let family = &vocabulary.families[saying.family];
    vocabulary.price_ln
        + family.price_ln
        + shape_price_ln(family.grid.len(), shape)
        + SIBLING_LN * (saying.carriers.len() - 1) as f64
}

/// The best phrase of the grammar at its best shape; none where none can come near `beat_ln`.
fn phrase(problem: &Problem<'_>, view: &View, beat_ln: f64) -> Option<Contender> {
    let finalists = finalists(problem, view);
    let best = finalists.first()?.1.ln_odds;
    if best < beat_ln - SHAPE_MAY_ADD_LN {
        return None;
    }
    let worth = finalists.iter().filter(|(_, score)| score.ln_odds > best - NAMED_WITHIN_LN);
    let mut shaped: Vec<Contender> = Vec::new();
    let mut seen: Vec<(&str, usize)> = Vec::new();
    for &(phrase, score) in worth {
        let Saying { family, carriers } = &problem.vocabulary.phrases[phrase];
        let idea = (problem.vocabulary.families[*family].kin.as_str(), carriers[0]);
        if seen.contains(&idea) || seen.len() == SHAPED_FINALISTS {
            continue;
        }
        seen.push(idea);
        shaped.extend(shaped_kin(problem, view, *family, carriers, &score));
    }
    let best = shaped.into_iter().max_by(|a, b| a.item.ln_odds.total_cmp(&b.item.ln_odds))?;
    Some(with_siblings(problem, view, best))
}

/// The best phrases on the grid, scored under the whole bank, best first.
fn finalists(problem: &Problem<'_>, view: &View) -> Vec<(usize, Score)> {
    let library = &problem.vocabulary.library;
    let bank = &problem.bank;
    // Noise models that matter: with nothing added, and with what the catalogue offers.
    let mut members = view.situation.likeliest();
    members.truncate(OPEN_MEMBERS - 1);
    let best_named = view.named.scores.iter().max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds));
    // Structure makes noise models look correlated; the white one is where it stands out.
    for extra in best_named.map(|score| score.member).into_iter().chain([WHITE]) {
        if !members.contains(&extra) {
            members.push(extra);
        }
    }
    let coarse = bank.scan(library, &members, &problem.open_blocks(&members), &view.situation);
    let mut order: Vec<usize> = (0..coarse.scores.len()).collect();
    order.sort_by(|&a, &b| coarse.scores[b].ln_odds.total_cmp(&coarse.scores[a].ln_odds));
    order.truncate(OPEN_FINALISTS);
    let subset = library.subset(&order);
    let all = bank.all();
    let blocks = bank.blocks(&subset, &all);
    let fine = bank.scan(&subset, &all, &blocks.iter().collect::<Vec<_>>(), &view.situation);
    let mut finalists: Vec<(usize, Score)> = order.into_iter().zip(fine.scores).collect();
    finalists.sort_by(|a, b| b.1.ln_odds.total_cmp(&a.1.ln_odds));
    finalists
}

/// A family and its kin at their best shapes; of the kin only the most promising on their grids.
fn shaped_kin(
    problem: &Problem<'_>,
    view: &View,
    family: usize,
    carriers: &[usize],
    like: &Score,
) -> Vec<Contender> {
    let saying = |family: usize| Saying { family, carriers: carriers.to_vec() };
    let own = &problem.vocabulary.families[family];
    let Some(form) = Form::new(problem, view, saying(family), like, &own.grid) else { return Vec::new() };
    let parent = form.shaped(problem, view);
    let numbers: Vec<(&str, f64)> =
        own.numbers.iter().zip(&parent.item.shape).map(|(number, value)| (number.name, *value)).collect();
    let mut kin: Vec<Form<'_>> = problem
        .vocabulary
        .kin(family)
        .into_iter()
        .filter_map(|kin| {
            let grid = problem.vocabulary.families[kin].grid_at(&numbers);
            Form::new(problem, view, saying(kin), like, &grid)
        })
        .collect();
    kin.sort_by(|a, b| b.start.gain_ln.total_cmp(&a.start.gain_ln));
    kin.truncate(SHAPED_KIN);
    kin.into_iter().map(|form| form.shaped(problem, view)).chain([parent]).collect()
}

/// A saying on its way to its best shape.
struct Form<'a> {
    view: &'a View,
    saying: Saying,
    /// Best of its grid.
    start: Shaped,
    /// The noise under which it is shaped.
    like: &'a Score,
}

impl<'a> Form<'a> {
    fn new(
        problem: &Problem<'_>,
        view: &'a View,
        saying: Saying,
        like: &'a Score,
        grid: &[Vec<f64>],
    ) -> Option<Self> {
        let none = Shaped { shape: Vec::new(), columns: DMatrix::zeros(0, 0), gain_ln: f64::NEG_INFINITY };
        let mut form = Self { view, saying, start: none, like };
        for shape in grid {
            let Some(columns) = form.columns(problem, shape) else { continue };
            let gain_ln = form.gain_ln(problem, &columns);
            if gain_ln > form.start.gain_ln {
                form.start = Shaped { shape: shape.clone(), columns, gain_ln };
            }
        }
        form.start.gain_ln.is_finite().then_some(form)
    }

    fn columns(&self, problem: &Problem<'_>, shape: &[f64]) -> Option<DMatrix<f64>> {
        let columns = problem.vocabulary.columns(problem.experiment, &self.saying, shape);
        columns.iter().all(|x| x.is_finite()).then_some(columns)
    }

    fn gain_ln(&self, problem: &Problem<'_>, columns: &DMatrix<f64>) -> f64 {
        problem.bank.gain_ln(columns, self.like.member, self.like.motion, &self.view.situation)
    }

    fn shaped(self, problem: &Problem<'_>, view: &View) -> Contender {
        let family = &problem.vocabulary.families[self.saying.family];
        let limits: Vec<(f64, f64)> = family.numbers.iter().map(|number| (number.low, number.high)).collect();
        let within = stretches(&family.grid, &self.start.shape, Some(&limits));
        let columns = |shape: &[f64]| self.columns(problem, shape);
        let gain_ln = |columns: &DMatrix<f64>| self.gain_ln(problem, columns);
        let Shaped { shape, columns, .. } = refined(self.start.clone(), &within, columns, gain_ln);
        weighed(problem, view, self.saying.clone(), shape, columns)
    }
}

/// The evidence of a saying at one shape.
fn weighed(
    problem: &Problem<'_>,
    view: &View,
    saying: Saying,
    shape: Vec<f64>,
    columns: DMatrix<f64>,
) -> Contender {
    let price_ln = saying_price_ln(problem, &saying, &shape);
    let natural = problem.vocabulary.families[saying.family].natural;
    let all = problem.bank.all();
    let score = problem.bank.weigh(&columns, -price_ln, natural, &all, &view.situation);
    Contender { item: Item { what: What::Open(saying), shape, columns, ln_odds: score.ln_odds }, score }
}

/// The same with fewer or further components of the same site, as long as that pays.
fn with_siblings(problem: &Problem<'_>, view: &View, mut best: Contender) -> Contender {
    let What::Open(saying) = best.item.what.clone() else { return best };
    for sibling in saying.carriers.iter().copied().chain(problem.vocabulary.siblings(saying.carriers[0])) {
        let What::Open(mut other) = best.item.what.clone() else { return best };
        match other.carriers.iter().position(|c| *c == sibling) {
            Some(_) if other.carriers.len() == 1 => continue,
            Some(k) => {
                other.carriers.remove(k);
            }
            None => other.carriers.push(sibling),
        }
        let trial = shaped_at(problem, view, other, &best);
        if trial.item.ln_odds > best.item.ln_odds {
            best = trial;
        }
    }
    best
}

fn shaped_at(problem: &Problem<'_>, view: &View, saying: Saying, like: &Contender) -> Contender {
    let shape = like.item.shape.clone();
    let columns = problem.vocabulary.columns(problem.experiment, &saying, &shape);
    weighed(problem, view, saying, shape, columns)
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
