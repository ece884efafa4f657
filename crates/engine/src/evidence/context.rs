//! Libraries and readings as one noise model sees them.

use super::SURVIVAL;
use nalgebra::{DMatrix, DVector};

/// What a library looks like under one noise model.
pub struct Blocks {
    /// Motion × column.
    pub on_motion: DMatrix<f64>,
    /// Gram matrices of all parts one after the other, row by row.
    pub grams: Vec<f64>,
    pub norm_squared: Vec<f64>,
}

/// Everything of one member that a scan needs for one set of readings and chosen columns.
pub struct Context {
    /// Wᵀ of the whitened, projected readings (first) and chosen columns; vector × row.
    pub back: DMatrix<f64>,
    /// One for each variance of the repeatable motions.
    pub soft: Vec<Soft>,
}

/// A context under one variance of the repeatable motions.
pub struct Soft {
    pub rho: f64,
    pub weights: DVector<f64>,
    pub on_motion: DMatrix<f64>,
    pub chosen: Chosen,
    /// ν.
    pub freedom: f64,
    pub rss: f64,
    /// ln marginal likelihood of nothing more, with the prior of this noise.
    pub nothing: f64,
}

/// Chosen columns folded into the model by a Cholesky factor of their inner products, column by column.
pub struct Chosen {
    pub kept: Vec<usize>,
    /// Inverse of the lower factor of the kept columns.
    inverse_lower: DMatrix<f64>,
    /// Inner products of the orthonormalised chosen columns with the readings.
    pub on_readings: DVector<f64>,
    pub rss: f64,
    pub log_det: f64,
}

impl Chosen {
    /// `inner`: inner products of readings (first) and chosen columns; `norm_squared`: of the same before projection. What hardly
    /// survives is imitated by the model and the columns before it.
    pub fn new(inner: &DMatrix<f64>, norm_squared: &[f64]) -> Self {
        let count = inner.nrows() - 1;
        let mut kept: Vec<usize> = Vec::new();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let mut log_det = 0.0;
        for j in 0..count {
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (i, other) in kept.iter().enumerate() {
                let dot: f64 = row.iter().zip(&rows[i]).map(|(a, b)| a * b).sum();
                row.push((inner[(1 + j, 1 + other)] - dot) / rows[i][i]);
            }
            let left = inner[(1 + j, 1 + j)] - row.iter().map(|x| x * x).sum::<f64>();
            if left > SURVIVAL * SURVIVAL * norm_squared[1 + j] && left > 1e-200 {
                log_det += left.ln();
                row.push(left.sqrt());
                kept.push(j);
                rows.push(row);
            }
        }
        let lower = DMatrix::from_fn(kept.len(), kept.len(), |i, j| if j <= i { rows[i][j] } else { 0.0 });
        let inverse_lower = lower.try_inverse().expect("every pivot kept is positive");
        let right = DVector::from_fn(kept.len(), |i, _| inner[(0, 1 + kept[i])]);
        let on_readings = &inverse_lower * right;
        let rss = inner[(0, 0)] - on_readings.norm_squared();
        Self { kept, inverse_lower, on_readings, rss, log_det }
    }

    /// Inner products of the library with the orthonormalised chosen columns, from `products` (readings first).
    pub fn orthonormal(&self, products: &DMatrix<f64>) -> DMatrix<f64> {
        let mut raw = DMatrix::zeros(products.nrows(), self.kept.len());
        for (i, &j) in self.kept.iter().enumerate() {
            raw.set_column(i, &products.column(1 + j));
        }
        raw * self.inverse_lower.transpose()
    }
}
