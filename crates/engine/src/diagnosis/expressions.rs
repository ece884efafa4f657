//! The best that the open grammar has to say: scanned on its grid, then brought to its best shape with its relatives and its further
//! components.

use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{NAMED_WITHIN_LN, SHAPE_MAY_ADD_LN, Scored, term_price_ln};
use crate::diagnosis::view::{Item, View, What};
use crate::diagnosis::vocabulary::Term;
use crate::evidence::{Score, WHITE};
use nalgebra::DMatrix;

/// Noise models under which the whole grammar is scored; its best terms are then scored under all.
const OPEN_MEMBERS: usize = 3;
/// Best terms of the grammar that are scored under the whole bank.
const OPEN_FINALISTS: usize = 10;
/// Of these, how many are brought to their best shape, with their relatives.
const SHAPED_FINALISTS: usize = 3;
/// Of their relatives, how many.
const SHAPED_RELATIVES: usize = 3;
/// The best term of the grammar at its best shape; none where none can come near `beat_ln`.
pub fn best_term(scan: &Scan<'_>, view: &View, beat_ln: f64) -> Option<Scored> {
    let finalists = finalists(scan, view);
    let best = finalists.first()?.1.ln_odds;
    if best < beat_ln - SHAPE_MAY_ADD_LN {
        return None;
    }
    let worth = finalists.iter().filter(|(_, score)| score.ln_odds > best - NAMED_WITHIN_LN);
    let mut shaped: Vec<Scored> = Vec::new();
    let mut seen: Vec<(&str, usize)> = Vec::new();
    for &(term, score) in worth {
        let Term { family, carriers } = &scan.vocabulary.terms[term];
        let idea = (scan.vocabulary.families[*family].idea.as_str(), carriers[0]);
        if seen.contains(&idea) || seen.len() == SHAPED_FINALISTS {
            continue;
        }
        seen.push(idea);
        shaped.extend(shaped_relatives(scan, view, *family, carriers, &score));
    }
    let best = shaped.into_iter().max_by(|a, b| a.item.ln_odds.total_cmp(&b.item.ln_odds))?;
    Some(with_siblings(scan, view, best))
}

/// The best terms on the grid, scored under the whole bank, best first.
fn finalists(scan: &Scan<'_>, view: &View) -> Vec<(usize, Score)> {
    let library = &scan.vocabulary.library;
    let bank = &scan.bank;
    // Noise models that matter: with nothing added, and with what the catalogue offers.
    let mut members = view.situation.likeliest();
    members.truncate(OPEN_MEMBERS - 1);
    let best_named = view.named.iter().max_by(|a, b| a.ln_odds.total_cmp(&b.ln_odds));
    // Structure makes noise models look correlated; the white one is where it stands out.
    for extra in best_named.map(|score| score.member).into_iter().chain([WHITE]) {
        if !members.contains(&extra) {
            members.push(extra);
        }
    }
    let coarse = bank.scan(library, &members, &scan.open_blocks(&members), &view.situation);
    let mut order: Vec<usize> = (0..coarse.len()).collect();
    order.sort_by(|&a, &b| coarse[b].ln_odds.total_cmp(&coarse[a].ln_odds));
    order.truncate(OPEN_FINALISTS);
    let subset = library.subset(&order);
    let all = bank.all();
    let blocks = bank.blocks(&subset, &all);
    let fine = bank.scan(&subset, &all, &blocks.iter().collect::<Vec<_>>(), &view.situation);
    let mut finalists: Vec<(usize, Score)> = order.into_iter().zip(fine).collect();
    finalists.sort_by(|a, b| b.1.ln_odds.total_cmp(&a.1.ln_odds));
    finalists
}

/// A family and its relatives at their best shapes; of the relatives only the most promising on their grids.
fn shaped_relatives(
    scan: &Scan<'_>,
    view: &View,
    family: usize,
    carriers: &[usize],
    like: &Score,
) -> Vec<Scored> {
    let term = |family: usize| Term { family, carriers: carriers.to_vec() };
    let own = &scan.vocabulary.families[family];
    let Some(form) = Form::new(scan, view, term(family), like, &own.grid) else { return Vec::new() };
    let parent = form.shaped(scan, view);
    let numbers: Vec<(&str, f64)> =
        own.numbers.iter().zip(&parent.item.shape).map(|(number, value)| (number.name, *value)).collect();
    let mut relatives: Vec<Form<'_>> = scan
        .vocabulary
        .relatives(family)
        .into_iter()
        .filter_map(|relative| {
            let grid = scan.vocabulary.families[relative].grid_at(&numbers);
            Form::new(scan, view, term(relative), like, &grid)
        })
        .collect();
    relatives.sort_by(|a, b| b.start.gain_ln.total_cmp(&a.start.gain_ln));
    relatives.truncate(SHAPED_RELATIVES);
    relatives.into_iter().map(|form| form.shaped(scan, view)).chain([parent]).collect()
}

/// A term on its way to its best shape.
struct Form<'a> {
    view: &'a View,
    term: Term,
    /// Best of its grid.
    start: Shaped,
    /// The noise under which it is shaped.
    like: &'a Score,
}

impl<'a> Form<'a> {
    fn new(scan: &Scan<'_>, view: &'a View, term: Term, like: &'a Score, grid: &[Vec<f64>]) -> Option<Self> {
        let none = Shaped { shape: Vec::new(), columns: DMatrix::zeros(0, 0), gain_ln: f64::NEG_INFINITY };
        let mut form = Self { view, term, start: none, like };
        for shape in grid {
            let Some(columns) = form.columns(scan, shape) else { continue };
            let gain_ln = form.gain_ln(scan, &columns);
            if gain_ln > form.start.gain_ln {
                form.start = Shaped { shape: shape.clone(), columns, gain_ln };
            }
        }
        form.start.gain_ln.is_finite().then_some(form)
    }

    fn columns(&self, scan: &Scan<'_>, shape: &[f64]) -> Option<DMatrix<f64>> {
        let columns = scan.vocabulary.columns(&scan.experiment, &self.term, shape);
        columns.iter().all(|x| x.is_finite()).then_some(columns)
    }

    fn gain_ln(&self, scan: &Scan<'_>, columns: &DMatrix<f64>) -> f64 {
        scan.bank.gain_ln(columns, self.like.member, self.like.motion, &self.view.situation)
    }

    fn shaped(self, scan: &Scan<'_>, view: &View) -> Scored {
        let family = &scan.vocabulary.families[self.term.family];
        let limits: Vec<(f64, f64)> = family.numbers.iter().map(|number| (number.low, number.high)).collect();
        let within = stretches(&family.grid, &self.start.shape, Some(&limits));
        let columns = |shape: &[f64]| self.columns(scan, shape);
        let gain_ln = |columns: &DMatrix<f64>| self.gain_ln(scan, columns);
        let Shaped { shape, columns, .. } = refined(self.start.clone(), &within, columns, gain_ln);
        weighed(scan, view, self.term.clone(), shape, columns)
    }
}

/// The evidence of a term at one shape.
fn weighed(scan: &Scan<'_>, view: &View, term: Term, shape: Vec<f64>, columns: DMatrix<f64>) -> Scored {
    let price_ln = term_price_ln(scan, &term, &shape);
    let natural = scan.vocabulary.families[term.family].natural;
    let all = scan.bank.all();
    let score = scan.bank.weigh(&columns, -price_ln, natural, &all, &view.situation);
    Scored { item: Item { what: What::Open(term), shape, columns, ln_odds: score.ln_odds }, score }
}

/// The same with fewer or further components of the same site, as long as that pays.
fn with_siblings(scan: &Scan<'_>, view: &View, mut best: Scored) -> Scored {
    let What::Open(term) = best.item.what.clone() else { return best };
    for sibling in term.carriers.iter().copied().chain(scan.vocabulary.siblings(term.carriers[0])) {
        let What::Open(mut other) = best.item.what.clone() else { return best };
        match other.carriers.iter().position(|c| *c == sibling) {
            Some(_) if other.carriers.len() == 1 => continue,
            Some(k) => {
                other.carriers.remove(k);
            }
            None => other.carriers.push(sibling),
        }
        let trial = shaped_at(scan, view, other, &best);
        if trial.item.ln_odds > best.item.ln_odds {
            best = trial;
        }
    }
    best
}

fn shaped_at(scan: &Scan<'_>, view: &View, term: Term, like: &Scored) -> Scored {
    let shape = like.item.shape.clone();
    let columns = scan.vocabulary.columns(&scan.experiment, &term, &shape);
    weighed(scan, view, term, shape, columns)
}
