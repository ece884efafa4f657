//! Several missing effects at once: add the best, score again, try to swap each; at every step the open grammar duels with
//! the catalogue (docs/design/statistics.md §3, §4).

use crate::diagnosis::contest::{odds_to_beat, winner};
use crate::diagnosis::least_squares::Fit;
use crate::diagnosis::problem::Problem;
use crate::diagnosis::vocabulary::Saying;
use crate::evidence::{Scan, Situation, stacked};
use nalgebra::DMatrix;

/// Rounds of swapping.
const SWEEPS: usize = 2;
/// Additions tried for each that may stay.
const ROUNDS_PER_ITEM: usize = 2;

/// What was added to the model.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// Index of a named effect.
    Named(usize),
    /// Something without a name.
    Open(Saying),
}

/// One addition with its columns.
#[derive(Clone, Debug)]
pub struct Item {
    pub what: What,
    /// Shape numbers.
    pub shape: Vec<f64>,
    /// Column × row.
    pub columns: DMatrix<f64>,
    /// ln odds when it was last scored, the others in the model.
    pub ln_odds: f64,
}

impl Item {
    pub fn is_open(&self) -> bool {
        matches!(self.what, What::Open(_))
    }
}

/// The readings with some columns in the model, and what the catalogue scores beside them.
pub struct View {
    /// Column × row.
    pub chosen: DMatrix<f64>,
    pub fit: Fit,
    pub situation: Situation,
    pub named: Scan,
}

impl View {
    /// With `chosen` (column × row) in the model.
    pub fn of(problem: &Problem<'_>, chosen: DMatrix<f64>) -> Self {
        let fit = problem.fit(&chosen);
        let situation = problem.bank.situation(&fit.readings, &chosen);
        let all = problem.bank.all();
        let named = problem.bank.scan(&problem.named, &all, &problem.named_blocks(), &situation);
        Self { chosen, fit, situation, named }
    }
}

/// Columns of several items together.
pub fn columns_of<'a>(items: impl Iterator<Item = &'a Item>, rows: usize) -> DMatrix<f64> {
    items.fold(DMatrix::zeros(0, rows), |all, item| stacked(&all, &item.columns))
}

/// The set of additions that together explain what is left, at most `most`, and true when nothing worth claiming is left beside it.
pub fn search(problem: &Problem<'_>, first: &View, claim_ln: f64, most: usize) -> (Vec<Item>, bool) {
    let rows = problem.experiment.rows();
    let mut items: Vec<Item> = Vec::new();
    let mut next = winner(problem, first, &[], claim_ln);
    // Swapping may drop an item that comes back: the rounds are counted, not the items.
    for _ in 0..ROUNDS_PER_ITEM * most {
        let Some(item) = next else { return (items, true) };
        if items.len() == most {
            break;
        }
        items.push(item);
        if items.len() > 1 {
            swap(problem, &mut items, claim_ln);
        }
        let view = View::of(problem, columns_of(items.iter(), rows));
        next = winner(problem, &view, &taken(&items, usize::MAX), claim_ln);
    }
    (items, false)
}

fn swap(problem: &Problem<'_>, items: &mut Vec<Item>, claim_ln: f64) {
    let rows = problem.experiment.rows();
    for _ in 0..SWEEPS {
        let mut changed = false;
        let mut i = 0;
        while i < items.len() {
            let others = columns_of(items.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, x)| x), rows);
            let view = View::of(problem, others);
            match winner(problem, &view, &taken(items, i), claim_ln) {
                // The others explain it by now.
                None => {
                    items.remove(i);
                    changed = true;
                    continue;
                }
                Some(item) if item.what == items[i].what => items[i] = item,
                Some(item) => {
                    let stays = odds_to_beat(problem, &view, &items[i], &item);
                    if item.ln_odds > stays {
                        items[i] = item;
                        changed = true;
                    }
                }
            }
            i += 1;
        }
        if !changed {
            break;
        }
    }
}

fn taken(items: &[Item], except: usize) -> Vec<usize> {
    let named = |(j, item): (usize, &Item)| match item.what {
        What::Named(group) if j != except => Some(group),
        _ => None,
    };
    items.iter().enumerate().filter_map(named).collect()
}
