//! Covariance from clusters of the residual, and the sums over the data from which it and the held-out error follow.
//!
//! For runs with few readings and for quick fits; else [`crate::fit::structured`] knows better.
//!
//! Classical: C = s² (AᵀWA)⁻¹, s² not below the variance that the weights stand for. Cluster-robust:
//! C' = (AᵀA)⁻¹ (Σ_c g_c g_cᵀ) (AᵀA)⁻¹ · m/(m−1), g_c = A_cᵀ r_c over the m clusters (pass × position of the slow axis). Given: C with
//! each parameter's row and column widened by √max(1, C'_jj / C_jj), so a residual that goes in the same direction within a
//! cluster costs what it should, and chance never narrows anything.
//! Limits: an error that lasts longer than a cluster, or comes back in every pass, passes for several: under slow drift and
//! offsets of passes 95 % intervals hold the truth in 50–80 % of runs.

use crate::fit::gauss_newton::Converged;
use crate::noise::weights::Weights;
use crate::problem::design::Design;
use crate::problem::folds::{LeftOut, folds};
use crate::problem::passes::Passes;
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

/// Sums over the data that both need.
pub(crate) struct Sums {
    scores: DMatrix<f64>,
    /// One for each unit that is left out in turn.
    pub units: Vec<Unit>,
    pub left_out: LeftOut,
    /// True when all weights are 1.
    pub even: bool,
}

/// Normal equations of one unit.
pub(crate) struct Unit {
    pub gram: DMatrix<f64>,
    pub score: DVector<f64>,
    squares: f64,
    pub rows: usize,
    /// The same without weights, for a held-out error in plain mm; zero when all weights are alike.
    unweighted: Plain,
}

struct Plain {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    squares: f64,
}

impl Unit {
    fn new(width: usize) -> Self {
        let (gram, score) = (DMatrix::zeros(width, width), DVector::zeros(width));
        let unweighted = Plain { gram: gram.clone(), score: score.clone(), squares: 0.0 };
        Self { gram, score, squares: 0.0, rows: 0, unweighted }
    }

    /// AᵀA, Aᵀr and rᵀr without weights; `even` where the weighted ones are these.
    pub fn unweighted(&self, even: bool) -> (&DMatrix<f64>, &DVector<f64>, f64) {
        let plain = &self.unweighted;
        if even {
            (&self.gram, &self.score, self.squares)
        } else {
            (&plain.gram, &plain.score, plain.squares)
        }
    }
}

impl Plain {
    fn add(&mut self, a: &DMatrixView<'_, f64>, r: &DVectorView<'_, f64>, root: &DVectorView<'_, f64>) {
        let mut a = a.clone_owned();
        a.column_iter_mut().for_each(|mut column| column.component_div_assign(root));
        let r = r.component_div(root);
        self.gram.gemm_tr(1.0, &a, &a, 1.0);
        self.score += a.tr_mul(&r);
        self.squares += r.norm_squared();
    }
}

pub(crate) fn sums(design: &Design<'_>, passes: &Passes, fit: &Converged, used: &[bool]) -> Sums {
    let determined = &fit.datum.determined;
    let width = determined.len();
    let folds = folds(design.experiment, passes);
    let mut scores = DMatrix::zeros(width, passes.clusters);
    let mut units: Vec<Unit> = (0..folds.count).map(|_| Unit::new(width)).collect();
    design.blocks(&mut |points, rows, columns| {
        let chosen = columns.select_columns(determined);
        let mut start = points.start;
        while start < points.end {
            // Consecutive points of the same unit and cluster go together.
            let same = |i: usize| {
                used[i] == used[start]
                    && folds.of_point[i] == folds.of_point[start]
                    && passes.cluster[i] == passes.cluster[start]
            };
            let end = (start..points.end).find(|&i| !same(i)).unwrap_or(points.end);
            let stretch = design.experiment.rows_of_points(&(start..end));
            if used[start] {
                let a = chosen.rows(stretch.start - rows.start, stretch.len());
                let r = fit.weighted_mm.rows(stretch.start, stretch.len());
                let score = a.tr_mul(&r);
                let mut of_cluster = scores.column_mut(passes.cluster[start]);
                of_cluster += &score;
                let unit = &mut units[folds.of_point[start]];
                unit.gram.gemm_tr(1.0, &a, &a, 1.0);
                unit.score += score;
                unit.squares += r.norm_squared();
                if !design.weights.even {
                    unit.unweighted.add(&a, &r, &design.weights.root.rows(stretch.start, stretch.len()));
                }
                unit.rows += stretch.len();
            }
            start = end;
        }
    });
    units.retain(|unit| unit.rows > 0);
    Sums { scores, units, left_out: folds.left_out, even: design.weights.even }
}

/// Covariance of the determined parameters from clusters.
pub(crate) fn covariance(fit: &Converged, sums: &Sums, weights: &Weights) -> DMatrix<f64> {
    let cofactor = fit.solver.cofactor();
    let classical = &cofactor * fit.reading_mm(weights).powi(2);
    let clusters = (0..sums.scores.ncols()).filter(|&c| sums.scores.column(c).amax() > 0.0).count();
    if clusters < 2 {
        return classical;
    }
    let spread = &cofactor * &sums.scores;
    let correction = clusters as f64 / (clusters - 1) as f64;
    let widen = DVector::from_fn(cofactor.nrows(), |j, _| {
        let robust = spread.row(j).norm_squared() * correction;
        if classical[(j, j)] > 0.0 { (robust / classical[(j, j)]).max(1.0).sqrt() } else { 1.0 }
    });
    DMatrix::from_fn(cofactor.nrows(), cofactor.ncols(), |i, j| classical[(i, j)] * widen[i] * widen[j])
}
