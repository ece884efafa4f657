//! What a method that chooses columns sees of a run.
//!
//! min ‖y − A x‖ with few of the columns, y and A after least squares with the base model, columns of rms 1. Everything follows from
//! G = AᵀA, b = Aᵀy and yᵀy. BIC = n ln(RSS/n) + k ln n [Schwarz 1978] assumes white noise, as users of these methods do.
//! Limits: columns that depend on others are made solvable by a ridge of 10⁻⁹ n, so either may be chosen.

use nalgebra::{DMatrix, DVector};

/// Keeps dependent columns solvable; in units of the squared norm of a column.
const DEPENDENT: f64 = 1e-9;

/// A method that chooses columns.
pub struct Baseline {
    /// Its name in tables.
    pub name: &'static str,
    /// The columns that it keeps.
    pub(super) chosen: fn(&Problem) -> Vec<usize>,
}

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
pub(super) struct Problem<'a> {
    pub gram: DMatrix<f64>,
    pub score: DVector<f64>,
    pub squares: f64,
    pub rows: usize,
    pub block_of: &'a [usize],
}

impl<'a> Problem<'a> {
    /// Of readings after the base model.
    pub fn new(library: &'a Library, readings: &DVector<f64>) -> Self {
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
    pub fn solve(&self, chosen: &[usize], ridge: f64) -> DVector<f64> {
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
    pub fn bic(&self, chosen: &[usize]) -> f64 {
        let n = self.rows as f64;
        n * (self.left(chosen) / n).ln() + chosen.len() as f64 * n.ln()
    }
}
