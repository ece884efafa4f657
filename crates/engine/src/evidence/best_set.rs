//! Evidence of a block of which some columns may be absent: a carriage that swings need not nod (docs/design/statistics.md §4.3).

use super::algebra::{NO_DIRECTION, turn};
use super::of_gram::evidence_of_gram;
use crate::noise::learned::Real;
use crate::noise::learned::sigma::Projected;
use nalgebra::DMatrix;

/// The best set of some columns of a block.
#[derive(Clone, Debug)]
pub struct BestSet {
    /// Indices of its columns.
    pub columns: Vec<usize>,
    /// ln Bayes factor against nothing, after the price.
    pub ln_bf: f64,
    /// What choosing the set costs, ln.
    pub price_ln: f64,
}

/// The best set of columns, found by leaving out one after the other, after the price of choosing it; none of no column.
pub fn best_set(here: &Projected, columns: &DMatrix<f64>) -> Option<BestSet> {
    let rms = |column: usize| columns.column(column).norm() / (columns.nrows() as f64).sqrt();
    let alive: Vec<usize> = (0..columns.ncols()).filter(|&column| rms(column) > 0.0).collect();
    let all = alive.len();
    let scaled = DMatrix::from_fn(columns.nrows(), all, |i, j| columns[(i, alive[j])] / rms(alive[j]));
    let single = scaled.map(|x| x as Real);
    let overlap = scaled.tr_mul(&scaled) / columns.nrows() as f64;
    let gram = here.grams(&single, &[all]).remove(0);
    let on_readings = single.tr_mul(&here.py).cast::<f64>();
    let white = here.sigma.white;
    let ln_bf = |set: &[usize]| {
        let within = |of: &DMatrix<f64>| of.select_rows(set).select_columns(set);
        let turn = turn(&within(&overlap), NO_DIRECTION);
        let gram = turn.transpose() * within(&gram) * &turn;
        evidence_of_gram(&gram, &turn.tr_mul(&on_readings.select_rows(set)), white).ln_bf
    };
    let without =
        |set: &[usize], column: usize| set.iter().copied().filter(|c| *c != column).collect::<Vec<_>>();
    let mut set: Vec<usize> = (0..all).collect();
    let mut best = (all > 0).then(|| BestSet { columns: alive.clone(), ln_bf: ln_bf(&set), price_ln: 0.0 });
    while set.len() > 1 {
        let smaller = set.iter().map(|&column| without(&set, column));
        let (ln, next) = smaller.map(|set| (ln_bf(&set), set)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        set = next;
        let price_ln = price_ln(all, set.len());
        if best.as_ref().is_none_or(|best| ln - price_ln > best.ln_bf) {
            let columns = set.iter().map(|&column| alive[column]).collect();
            best = Some(BestSet { columns, ln_bf: ln - price_ln, price_ln });
        }
    }
    best
}

/// One half for "not all", then every number of columns alike, then every set of that number alike.
fn price_ln(all: usize, some: usize) -> f64 {
    let sets_ln: f64 = (0..some).map(|i| ((all - i) as f64 / (i + 1) as f64).ln()).sum();
    2f64.ln() + ((all - 1) as f64).ln() + sets_ln
}
