//! The best that the open grammar has to say: scanned on its grid, then brought to its best shape with its kin and its further
//! components.

use crate::diagnosis::contest::{Contender, NAMED_WITHIN_LN};
use crate::diagnosis::problem::Problem;
use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::search::{Item, View, What};
use crate::diagnosis::vocabulary::{SIBLING_LN, Saying};
use crate::evidence::{Score, WHITE};
use nalgebra::DMatrix;

/// Noise models under which the whole grammar is scored; its best phrases are then scored under all.
const OPEN_MEMBERS: usize = 3;
/// Best phrases of the grammar that are scored under the whole bank.
const OPEN_FINALISTS: usize = 10;
/// Of these, how many are brought to their best shape, with their kin.
const SHAPED_FINALISTS: usize = 3;
/// Of their kin, how many.
const SHAPED_KIN: usize = 3;
/// What the best shape may add to odds on the grid.
pub const SHAPE_MAY_ADD_LN: f64 = 12.0;
/// Price of each shape number that was brought to its best value, ln.
const NUMBER_LN: f64 = 1.0;

/// The best phrase of the grammar at its best shape; none where none can come near `beat_ln`.
pub fn phrase(problem: &Problem<'_>, view: &View, beat_ln: f64) -> Option<Contender> {
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

/// Price of having chosen a shape, ln: one of the grid, then between its points.
pub fn shape_price_ln(grid: usize, shape: &[f64]) -> f64 {
    (grid.max(1) as f64).ln() + NUMBER_LN * shape.len() as f64
}

pub fn saying_price_ln(problem: &Problem<'_>, saying: &Saying, shape: &[f64]) -> f64 {
    let vocabulary = &problem.vocabulary;
    let family = &vocabulary.families[saying.family];
    vocabulary.price_ln
        + family.price_ln
        + shape_price_ln(family.grid.len(), shape)
        + SIBLING_LN * (saying.carriers.len() - 1) as f64
}
