//! An addition at its best shape with its score, and what choosing a shape costs.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::view::Item;
use crate::diagnosis::vocabulary::{SIBLING_LN, Term};
use crate::evidence::Score;

/// Effects and expressions this far behind the best (ln) are not brought to their best shape.
pub const NAMED_WITHIN_LN: f64 = 12.0;
/// What the best shape may add to odds on the grid.
pub const SHAPE_MAY_ADD_LN: f64 = 12.0;
/// Price of each shape number that was brought to its best value, ln.
const NUMBER_LN: f64 = 1.0;

/// One that takes part, at its best shape.
#[derive(Clone)]
pub struct Scored {
    pub item: Item,
    pub score: Score,
}

/// Price of having chosen a shape, ln: one of the grid, then between its points.
pub fn shape_price_ln(grid: usize, shape: &[f64]) -> f64 {
    (grid.max(1) as f64).ln() + NUMBER_LN * shape.len() as f64
}

pub fn term_price_ln(scan: &Scan<'_>, term: &Term, shape: &[f64]) -> f64 {
    let vocabulary = &scan.vocabulary;
    let family = &vocabulary.families[term.family];
    vocabulary.price_ln
        + family.price_ln
        + shape_price_ln(family.grid.len(), shape)
        + SIBLING_LN * (term.carriers.len() - 1) as f64
}
