//! What else one would do with the same columns: plain methods of choosing some of many, beside which the blind trial sets the diagnosis.
//!
//! min ‖y − A x‖ with few of the columns, y and A after least squares with the base model, columns of rms 1. Everything follows from
//! G = AᵀA, b = Aᵀy and yᵀy. Each method counts with BIC = n ln(RSS/n) + k ln n [Schwarz 1978]: white noise, as its users
//! assume.
//! Limits: columns that depend on others are told from them by a ridge of 10⁻⁹ n, so either may be chosen.

mod forward;
mod omp;
mod stlsq;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

/// Keeps dependent columns solvable; in units of the squared norm of a column.
const DEPENDENT: f64 = 1e-9;

/// A method that chooses columns.
pub struct Baseline {
    /// Its name in tables.
    pub name: &'static str,
    /// The columns that it keeps.
    chosen: fn(&Problem) -> Vec<usize>,
}

/// All of them.
pub const BASELINES: [Baseline; 3] = [stlsq::BASELINE, omp::BASELINE, forward::BASELINE];

/// Columns of many effects.
pub struct Library {
    /// Rows × columns, mm, after the base model.
    pub columns: DMatrix<f64>,
    /// The effect of each column.
    pub effect_of: Vec<String>,
    /// Columns of one effect at one shape, which come together, have one number; rising by one.
    pub block_of: Vec<usize>,
}

/// Readings and columns of one run as the methods see them.
struct Problem<'a> {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    squares: f64,
    rows: usize,
    block_of: &'a [usize],
}

impl<'a> Problem<'a> {
    /// Of readings after the base model.
    fn new(library: &'a Library, readings: &DVector<f64>) -> Self {
        let rows = readings.len();
        let mut columns = library.columns.clone();
        columns.column_iter_mut().for_each(|mut column| column *= (rows as f64).sqrt() / column.norm());
        Self {
            gram: columns.tr_mul(&columns),
            score: columns.tr_mul(readings),
            squares: readings.norm_squared(),
            rows,
            block_of: &library.block_of,
        }
    }

    /// Least squares with the chosen columns alone; `ridge` in units of the squared norm of a column.
    fn solve(&self, chosen: &[usize], ridge: f64) -> DVector<f64> {
        let mut gram = self.gram.select_columns(chosen).select_rows(chosen);
        (0..chosen.len()).for_each(|j| gram[(j, j)] += (DEPENDENT + ridge) * self.rows as f64);
        let factors = gram.cholesky().expect("a ridge makes it positive");
        factors.solve(&self.score.select_rows(chosen))
    }

    /// What the chosen columns leave of yᵀy.
    fn left(&self, chosen: &[usize]) -> f64 {
        let explained = self.solve(chosen, 0.0).dot(&self.score.select_rows(chosen));
        (self.squares - explained).max(f64::MIN_POSITIVE)
    }

    /// n ln(RSS/n) + k ln n.
    fn bic(&self, chosen: &[usize]) -> f64 {
        let n = self.rows as f64;
        n * (self.left(chosen) / n).ln() + chosen.len() as f64 * n.ln()
    }
}

/// The effects that each method names, in the order of [`BASELINES`].
pub fn named(library: &Library, readings: &DVector<f64>) -> Vec<BTreeSet<String>> {
    let problem = Problem::new(library, readings);
    let effects = |chosen: Vec<usize>| chosen.into_iter().map(|j| library.effect_of[j].clone()).collect();
    BASELINES.iter().map(|baseline| effects((baseline.chosen)(&problem))).collect()
}
