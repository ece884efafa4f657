//! The best that the open grammar has to say: screened on its grid, the noise learned with it in the model, then brought to its best shape with
//! its relatives and its further components.

use crate::diagnosis::named::natural_share;
use crate::diagnosis::refine::{Shaped, refined, stretches};
use crate::diagnosis::scan::Scan;
use crate::diagnosis::scored::{SHAPE_MAY_ADD_LN, Scored, term_price_ln};
use crate::diagnosis::view::{Item, Relearned, View, What, evidence_relearned};
use crate::diagnosis::vocabulary::{Screened, Term};
use crate::evidence::{Evidence, evidence_of, parallel, turned};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Best terms of the grammar, at the learned noise and in a quiet one, whose bundles are looked at too.
const FINALISTS: usize = 6;
/// Ideas that are brought to their best shape, with their relatives.
const SHAPED_IDEAS: usize = 2;
/// Of their relatives, how many.
const SHAPED_RELATIVES: usize = 3;

/// The best term of the grammar at its best shape; none where none can come near `beat_ln` at the learned or at the quiet noise.
pub fn best_term(scan: &Scan<'_>, view: &View, beat_ln: [f64; 2]) -> Option<Scored> {
    let finalists = finalists(scan, view, beat_ln);
    let mut starts: Vec<&Screened> = Vec::new();
    let idea = |start: &Screened| (&scan.vocabulary.families[start.term.family].idea, start.term.carriers[0]);
    for start in &finalists {
        if starts.len() < SHAPED_IDEAS && starts.iter().all(|other| idea(other) != idea(start)) {
            starts.push(start);
        }
    }
    let first_best = |a: Scored, b: Scored| if b.item.ln_odds > a.item.ln_odds { b } else { a };
    let shaped = parallel(starts.len(), |i| {
        let start = starts[i];
        let shape = &scan.vocabulary.families[start.term.family].grid[start.shape];
        let noise = Arc::new(view.relearned(scan, &turned(&columns(scan, &start.term, shape)?))?);
        let relatives = shaped_relatives(scan, view, &start.term, &noise);
        relatives.into_iter().reduce(first_best)
    });
    Some(with_siblings(scan, view, shaped.into_iter().flatten().reduce(first_best)?))
}

/// The best terms on the grid, bundles included, best first.
fn finalists(scan: &Scan<'_>, view: &View, beat_ln: [f64; 2]) -> Vec<Screened> {
    let points = &scan.remainder.rows.points;
    let price = |screened: &Screened| {
        let family = &scan.vocabulary.families[screened.term.family];
        term_price_ln(scan, &screened.term, &[]) - (family.grid.len().max(1) as f64).ln()
    };
    let best_at = |here, beat_ln: f64| {
        let mut all = scan.vocabulary.screened(points, here);
        all.sort_by(|a, b| (b.ln_bf - price(b)).total_cmp(&(a.ln_bf - price(a))));
        all.truncate(FINALISTS);
        all.retain(|screened| screened.ln_bf - price(screened) > beat_ln - SHAPE_MAY_ADD_LN);
        let wider = |screened: &Screened| {
            let family = &scan.vocabulary.families[screened.term.family];
            let shape = screened.shape;
            scan.vocabulary.wider(&screened.term).into_iter().filter_map(move |term| {
                let columns = columns(scan, &term, &family.grid[shape])?;
                let ln_bf = evidence_of(here, &turned(&columns)).ln_bf - (family.grid.len() as f64).ln();
                Some(Screened { term, shape, ln_bf })
            })
        };
        let bundles: Vec<Screened> = all.iter().flat_map(wider).collect();
        all.extend(bundles);
        all
    };
    let mut all = best_at(&view.null.here, beat_ln[0]);
    // The learned noise may have swallowed it; then the quiet one has to see clearly more.
    let quiet = best_at(&view.quiet, beat_ln[1]);
    let by_odds = |a: &Screened, b: &Screened| (b.ln_bf - price(b)).total_cmp(&(a.ln_bf - price(a)));
    all.sort_by(by_odds);
    let mut quiet: Vec<Screened> = quiet;
    quiet.sort_by(by_odds);
    // Alternating: the best of each first.
    let mut merged = Vec::new();
    let (mut first, mut second) = (all.into_iter(), quiet.into_iter());
    loop {
        match (first.next(), second.next()) {
            (None, None) => return merged,
            (a, b) => merged.extend(a.into_iter().chain(b)),
        }
    }
}

fn columns(scan: &Scan<'_>, term: &Term, shape: &[f64]) -> Option<DMatrix<f64>> {
    let columns = scan.vocabulary.columns(&scan.remainder.rows.points, term, shape);
    columns.iter().all(|x| x.is_finite()).then_some(columns)
}

/// A term and its relatives at their best shapes; of the relatives only the most promising on their grids.
fn shaped_relatives(scan: &Scan<'_>, view: &View, term: &Term, noise: &Arc<Relearned>) -> Vec<Scored> {
    let families = &scan.vocabulary.families;
    let own = &families[term.family];
    let Some(form) = Form::new(scan, term.clone(), noise, &own.grid) else { return Vec::new() };
    let parent = form.shaped(scan, view);
    let numbers: Vec<(&str, f64)> =
        own.numbers.iter().zip(&parent.item.shape).map(|(number, value)| (number.name, *value)).collect();
    let relative = |family: usize| {
        let grid = families[family].grid_at(&numbers);
        Form::new(scan, Term { family, carriers: term.carriers.clone() }, noise, &grid)
    };
    let mut relatives: Vec<Form<'_>> =
        scan.vocabulary.relatives(term.family).into_iter().filter_map(relative).collect();
    relatives.sort_by(|a, b| b.start.gain_ln.total_cmp(&a.start.gain_ln));
    relatives.truncate(SHAPED_RELATIVES);
    relatives.into_iter().map(|form| form.shaped(scan, view)).chain([parent]).collect()
}

/// A term on its way to its best shape, at the noise learned with its idea in the model.
struct Form<'a> {
    term: Term,
    /// Best of its grid.
    start: Shaped,
    noise: &'a Arc<Relearned>,
}

impl<'a> Form<'a> {
    fn new(scan: &Scan<'_>, term: Term, noise: &'a Arc<Relearned>, grid: &[Vec<f64>]) -> Option<Self> {
        let mut start: Option<Shaped> = None;
        for shape in grid {
            let Some(columns) = columns(scan, &term, shape) else { continue };
            let gain_ln = evidence_of(&noise.alone, &turned(&columns)).ln_bf;
            if start.as_ref().is_none_or(|best| gain_ln > best.gain_ln) {
                start = Some(Shaped { shape: shape.clone(), columns, gain_ln });
            }
        }
        Some(Self { term, start: start?, noise })
    }

    fn shaped(self, scan: &Scan<'_>, view: &View) -> Scored {
        let family = &scan.vocabulary.families[self.term.family];
        let limits: Vec<(f64, f64)> = family.numbers.iter().map(|number| (number.low, number.high)).collect();
        let within = stretches(&family.grid, &self.start.shape, Some(&limits));
        let columns = |shape: &[f64]| columns(scan, &self.term, shape);
        let gain_ln = |columns: &DMatrix<f64>| evidence_of(&self.noise.alone, &turned(columns)).ln_bf;
        let Shaped { shape, columns, .. } = refined(self.start.clone(), &within, columns, gain_ln);
        scored(scan, view, self.term.clone(), shape, columns, self.noise)
    }
}

/// A term at one shape.
fn scored(
    scan: &Scan<'_>,
    view: &View,
    term: Term,
    shape: Vec<f64>,
    columns: DMatrix<f64>,
    noise: &Arc<Relearned>,
) -> Scored {
    let block = turned(&columns);
    let evidence = evidence_relearned(noise, &block);
    let natural = scan.vocabulary.families[term.family].natural;
    let noticeable = !natural || view.share(scan, noise, &block) > natural_share(scan, view);
    let ln_odds = evidence.ln_bf - term_price_ln(scan, &term, &shape);
    let item = Item { what: What::Open(term), shape, columns, ln_odds };
    let Evidence { ln_bf, fit_ln } = evidence;
    Scored { item, ln_bf, fit_ln, noise: noise.clone(), noticeable }
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
        let shape = best.item.shape.clone();
        let Some(columns) = columns(scan, &other, &shape) else { continue };
        let trial = scored(scan, view, other, shape, columns, &best.noise);
        if trial.item.ln_odds > best.item.ln_odds {
            best = trial;
        }
    }
    best
}
