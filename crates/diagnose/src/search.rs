//! Several missing effects at once: add the best, score again, try to swap each; at every step the open grammar duels with
//! the catalogue (DIAGNOSIS §3, §4).

use crate::evidence::{Scan, Score, stacked};
use crate::problem::{Fit, Problem};
use nalgebra::DMatrix;

/// Noise models under which the whole grammar is scored; its best phrases are then scored under all.
const OPEN_MEMBERS: usize = 3;
/// Best phrases of the grammar that are scored under the whole bank.
const OPEN_FINALISTS: usize = 8;
/// A phrase beats the catalogue when it leads by more than this.
const CLEAR_LEAD: f64 = 3.0;
/// A named effect that fits as well as the phrase, up to this, is the plainer explanation of the same shape.
const SAME_FIT: f64 = 3.0;
/// Rounds of swapping.
const SWEEPS: usize = 2;

/// What was added to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Index of a named effect.
    Named(usize),
    /// Index of a phrase of the grammar and its variant.
    Open(usize, usize),
}

/// One addition with its columns.
#[derive(Clone, Debug)]
pub struct Item {
    pub what: What,
    /// Shape numbers of a named effect.
    pub shape: Vec<f64>,
    /// Column × row.
    pub columns: DMatrix<f64>,
    /// ln odds when it was last scored, the others in the model.
    pub ln_odds: f64,
}

/// Both scans of one situation.
pub struct Scans {
    pub fit: Fit,
    pub named: Scan,
    /// Score and index of the best phrase.
    pub open: Option<(Score, usize)>,
}

/// Columns of several items together.
pub fn columns_of<'a>(items: impl Iterator<Item = &'a Item>, rows: usize) -> DMatrix<f64> {
    items.fold(DMatrix::zeros(0, rows), |all, item| stacked(&all, &item.columns))
}

/// Scores the catalogue alone with `chosen` (column × row) in the model.
pub fn scan_named(problem: &Problem<'_>, chosen: &DMatrix<f64>) -> Scans {
    let fit = problem.fit(chosen);
    let all: Vec<usize> = (0..problem.bank.members.len()).collect();
    let named = problem.bank.scan(&problem.named, &all, &problem.named_blocks(), &fit.readings, chosen);
    Scans { fit, named, open: None }
}

/// Scores everything with `chosen` (column × row) in the model.
pub fn scan(problem: &Problem<'_>, chosen: &DMatrix<f64>) -> Scans {
    let scans = scan_named(problem, chosen);
    let open = scan_open(problem, chosen, &scans.fit, &scans.named);
    Scans { open, ..scans }
}

pub fn scan_open(
    problem: &Problem<'_>,
    chosen: &DMatrix<f64>,
    fit: &Fit,
    named: &Scan,
) -> Option<(Score, usize)> {
    let library = &problem.vocabulary.library;
    // Noise models that matter: with nothing added, and with what the catalogue offers.
    let mut members: Vec<usize> = (0..named.nothing.len()).collect();
    members.sort_by(|&a, &b| named.nothing[b].total_cmp(&named.nothing[a]));
    members.truncate(OPEN_MEMBERS - 1);
    let best_named = named.scores.iter().max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds));
    // Structure makes noise models look correlated; the white one is where it stands out.
    for extra in best_named.map(|score| score.member).into_iter().chain([0]) {
        if !members.contains(&extra) {
            members.push(extra);
        }
    }
    let blocks = problem.open_blocks(&members);
    let coarse = problem.bank.scan(library, &members, &blocks, &fit.readings, chosen);
    let mut finalists: Vec<usize> = (0..coarse.scores.len()).collect();
    finalists.sort_by(|&a, &b| {
        coarse.scores[b]
            .log_likelihood_with_prior(library.groups[b].prior_ln)
            .total_cmp(&coarse.scores[a].log_likelihood_with_prior(library.groups[a].prior_ln))
    });
    finalists.truncate(OPEN_FINALISTS);
    let subset = library.subset(&finalists);
    let all: Vec<usize> = (0..problem.bank.members.len()).collect();
    let blocks = problem.bank.blocks(&subset, &all);
    let fine = problem.bank.scan(&subset, &all, &blocks.iter().collect::<Vec<_>>(), &fit.readings, chosen);
    let best =
        (0..finalists.len()).max_by(|&a, &b| fine.scores[a].ln_odds.total_cmp(&fine.scores[b].ln_odds))?;
    Some((fine.scores[best], finalists[best]))
}

/// The best addition, if any is worth claiming; `taken` are named effects that are in already.
pub fn pick(problem: &Problem<'_>, scans: &Scans, taken: &[usize], claim_ln: f64) -> Option<Item> {
    let free = |g: &usize| !taken.contains(g);
    let scores = &scans.named.scores;
    let named =
        (0..scores.len()).filter(free).max_by(|&a, &b| scores[a].ln_odds.total_cmp(&scores[b].ln_odds));
    let named = named.filter(|&g| scores[g].ln_odds > claim_ln);
    let open = scans.open.filter(|(score, _)| score.ln_odds > claim_ln);
    match (named, open) {
        (None, None) => None,
        (Some(g), None) => Some(named_item(problem, g, &scores[g])),
        (None, Some((score, phrase))) => Some(
            covering(problem, scans, &score, taken, claim_ln)
                .unwrap_or_else(|| open_item(problem, phrase, &score)),
        ),
        (Some(g), Some((score, phrase))) => {
            if score.ln_odds <= scores[g].ln_odds + CLEAR_LEAD {
                return Some(named_item(problem, g, &scores[g]));
            }
            let covering = covering(problem, scans, &score, taken, claim_ln);
            Some(covering.unwrap_or_else(|| open_item(problem, phrase, &score)))
        }
    }
}

/// The likeliest named effect that fits as well as a phrase: the phrase is then only a part of it at a lower price.
fn covering(
    problem: &Problem<'_>,
    scans: &Scans,
    phrase: &Score,
    taken: &[usize],
    claim_ln: f64,
) -> Option<Item> {
    let scores = &scans.named.scores;
    let covers = |g: &usize| {
        !taken.contains(g) && scores[*g].ln_odds > claim_ln && scores[*g].fit_ln > phrase.fit_ln - SAME_FIT
    };
    let best =
        (0..scores.len()).filter(covers).max_by(|&a, &b| scores[a].ln_odds.total_cmp(&scores[b].ln_odds))?;
    Some(named_item(problem, best, &scores[best]))
}

fn open_item(problem: &Problem<'_>, phrase: usize, score: &Score) -> Item {
    let columns = problem.vocabulary.library.part(phrase, score.part).transpose();
    Item { what: What::Open(phrase, score.part), shape: Vec::new(), columns, ln_odds: score.ln_odds }
}

/// A named effect at its best grid shape.
pub fn named_item(problem: &Problem<'_>, group: usize, score: &Score) -> Item {
    let shape = problem.shapes[group].grid[score.part].clone();
    let columns = problem.named.part(group, score.part).transpose();
    Item { what: What::Named(group), shape, columns, ln_odds: score.ln_odds }
}

/// Moves continuous shape numbers between the grid points to where the fit is best.
pub fn refine(
    problem: &Problem<'_>,
    mut item: Item,
    fit: &Fit,
    others: &DMatrix<f64>,
    member: usize,
) -> Item {
    let What::Named(group) = item.what else { return item };
    let shapes = &problem.shapes[group];
    if !shapes.continuous || shapes.grid.len() < 2 {
        return item;
    }
    let prepared = &problem.bank.members[member];
    let columns = |shape: &[f64]| {
        let columns = problem.experiment.columns(&problem.instances[group], shape).transpose();
        columns.iter().all(|x| x.is_finite()).then_some(columns)
    };
    let mut best_rss = prepared.rss(&fit.readings, others, &item.columns);
    for k in 0..item.shape.len() {
        let Some((low, high)) = neighbours(shapes.grid.iter().map(|s| s[k]), item.shape[k]) else { continue };
        let start = item.shape.clone();
        for i in 1..16 {
            let mut shape = start.clone();
            shape[k] = low + (high - low) * f64::from(i) / 16.0;
            let Some(trial) = columns(&shape) else { continue };
            let rss = prepared.rss(&fit.readings, others, &trial);
            if rss < best_rss {
                (best_rss, item.shape, item.columns) = (rss, shape, trial);
            }
        }
    }
    item
}

/// Grid values on both sides of `value`.
fn neighbours(grid: impl Iterator<Item = f64>, value: f64) -> Option<(f64, f64)> {
    let mut values: Vec<f64> = grid.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let at = values.iter().position(|v| *v == value)?;
    let (low, high) = (values[at.saturating_sub(1)], values[(at + 1).min(values.len() - 1)]);
    (high > low).then_some((low, high))
}

/// The set of additions that together explain what is left, at most `most`.
pub fn search(problem: &Problem<'_>, first: Scans, claim_ln: f64, most: usize) -> Vec<Item> {
    let rows = problem.experiment.rows();
    let mut items: Vec<Item> = Vec::new();
    let mut scans = first;
    while items.len() < most {
        let Some(item) = pick(problem, &scans, &taken(&items, usize::MAX), claim_ln) else { break };
        let others = columns_of(items.iter(), rows);
        let member = member_of(&scans, &item);
        items.push(refine(problem, item, &scans.fit, &others, member));
        if items.len() > 1 {
            swap(problem, &mut items, claim_ln);
        }
        scans = scan(problem, &columns_of(items.iter(), rows));
    }
    items
}

fn swap(problem: &Problem<'_>, items: &mut Vec<Item>, claim_ln: f64) {
    let rows = problem.experiment.rows();
    for _ in 0..SWEEPS {
        let mut changed = false;
        let mut i = 0;
        while i < items.len() {
            let others = columns_of(items.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, x)| x), rows);
            let scans = scan(problem, &others);
            match pick(problem, &scans, &taken(items, i), claim_ln) {
                // The others explain it by now.
                None => {
                    items.remove(i);
                    changed = true;
                }
                Some(item) => {
                    changed |= !same(&item.what, &items[i].what);
                    let member = member_of(&scans, &item);
                    items[i] = refine(problem, item, &scans.fit, &others, member);
                    i += 1;
                }
            }
        }
        if !changed {
            break;
        }
    }
}

fn same(a: &What, b: &What) -> bool {
    match (a, b) {
        (What::Named(a), What::Named(b)) | (What::Open(a, _), What::Open(b, _)) => a == b,
        _ => false,
    }
}

fn member_of(scans: &Scans, item: &Item) -> usize {
    match item.what {
        What::Named(group) => scans.named.scores[group].member,
        What::Open(..) => scans.open.map_or(scans.named.best_member, |(score, _)| score.member),
    }
}

fn taken(items: &[Item], except: usize) -> Vec<usize> {
    let named = |(j, item): (usize, &Item)| match item.what {
        What::Named(group) if j != except => Some(group),
        _ => None,
    };
    items.iter().enumerate().filter_map(named).collect()
}
