//! An addition at its best shape with its score, and what choosing a shape costs.

use crate::diagnosis::scan::Scan;
use crate::diagnosis::view::{Item, Relearned};
use crate::diagnosis::vocabulary::{SIBLING_LN, Term};
use crate::noise::learned::sigma::Sigma;
use std::sync::Arc;

/// What the best shape may add to odds on the grid.
pub const SHAPE_MAY_ADD_LN: f64 = 12.0;
/// Price of each shape number that was brought to its best value, ln.
const NUMBER_LN: f64 = 1.0;

/// One that takes part, the noise learned with it.
#[derive(Clone)]
pub struct Scored {
    pub item: Item,
    /// ln Bayes factor before any price.
    pub ln_bf: f64,
    /// How well it fits, whatever its columns cost, ln.
    pub fit_ln: f64,
    /// Learned with it in the model.
    pub noise: Arc<Relearned>,
    /// False for a repeatable motion that is no larger than natural.
    pub noticeable: bool,
}

impl Scored {
    /// Noise learned with it in the model.
    pub fn sigma(&self) -> &Arc<Sigma> {
        &self.noise.mode.here.sigma
    }
}

/// Price of having chosen a shape, ln: one of `tries`, then between its points.
pub fn shape_price_ln(tries: f64, shape: &[f64]) -> f64 {
    tries.max(1.0).ln() + NUMBER_LN * shape.len() as f64
}

pub fn term_price_ln(scan: &Scan<'_>, term: &Term, shape: &[f64]) -> f64 {
    let vocabulary = &scan.vocabulary;
    let family = &vocabulary.families[term.family];
    vocabulary.price_ln
        + family.price_ln
        + shape_price_ln(family.grid.len() as f64, shape)
        + SIBLING_LN * (term.carriers.len() - 1) as f64
}
