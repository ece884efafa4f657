//! Covariance from clusters of the residual, and prediction of left-out parts; one pass over the data.
//!
//! For runs on the fly, very long ones and those with few readings, and for quick fits; else [`crate::fit::structured`] knows better.
//!
//! Classical: C = s² (AᵀWA)⁻¹, s² not below the variance that the weights stand for. Cluster-robust:
//! C' = (AᵀA)⁻¹ (Σ_c g_c g_cᵀ) (AᵀA)⁻¹ · m/(m−1), g_c = A_cᵀ r_c over the m clusters (pass × position of the slow axis). Given: C with
//! each parameter's row and column widened by √max(1, C'_jj / C_jj), so a residual that goes in the same direction within a
//! cluster costs what it should, and chance never narrows anything.
//! Limits: an error that lasts longer than a cluster, or comes back in every pass, passes for several: under slow drift and
//! offsets of passes 95 % intervals hold the truth in 50–80 % of runs.
//! Held out: for each part q the change δ of the fit without q from the normal equations of the other parts, then the
//! residual of q with it. Directions that only q sees (its own ball setting) keep the value of the full fit.

use crate::fit::gauss_newton::Settled;
use crate::fit::identification::{Holdout, LeftOut};
use crate::noise::weights::Weights;
use crate::problem::design::Design;
use crate::problem::passes::Passes;
use nalgebra::{DMatrix, DMatrixView, DVector, DVectorView};

/// Relative eigenvalue of the kept normal equations below which the kept parts do not see a direction.
const UNSEEN: f64 = 1e-12;

/// Sums over the data that both need.
pub(crate) struct Sums {
    scores: DMatrix<f64>,
    parts: Vec<Part>,
    left_out: LeftOut,
    even: bool,
}

struct Part {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    squares: f64,
    rows: usize,
    /// The same without weights, for a held-out error in plain mm; zero when all weights are alike.
    unweighted: Plain,
}

struct Plain {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    squares: f64,
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

pub(crate) fn sums(design: &Design<'_>, passes: &Passes, fit: &Settled, used: &[bool]) -> Sums {
    let determined = &fit.gauge.determined;
    let width = determined.len();
    let left_out = if passes.passes > 1 { LeftOut::Passes } else { LeftOut::Blocks };
    let (part_of, count) = match left_out {
        LeftOut::Passes => (&passes.pass, passes.passes),
        LeftOut::Blocks => (&passes.block, passes.blocks),
    };
    let mut scores = DMatrix::zeros(width, passes.clusters);
    let mut parts: Vec<Part> = (0..count)
        .map(|_| Part {
            gram: DMatrix::zeros(width, width),
            score: DVector::zeros(width),
            squares: 0.0,
            rows: 0,
            unweighted: Plain {
                gram: DMatrix::zeros(width, width),
                score: DVector::zeros(width),
                squares: 0.0,
            },
        })
        .collect();
    design.blocks(&mut |points, rows, columns| {
        let chosen = columns.select_columns(determined);
        let mut start = points.start;
        while start < points.end {
            // Consecutive points of the same part and cluster go together.
            let same = |i: usize| {
                used[i] == used[start]
                    && part_of[i] == part_of[start]
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
                let part = &mut parts[part_of[start]];
                part.gram.gemm_tr(1.0, &a, &a, 1.0);
                part.score += score;
                part.squares += r.norm_squared();
                if !design.weights.even {
                    part.unweighted.add(&a, &r, &design.weights.root.rows(stretch.start, stretch.len()));
                }
                part.rows += stretch.len();
            }
            start = end;
        }
    });
    parts.retain(|part| part.rows > 0);
    Sums { scores, parts, left_out, even: design.weights.even }
}

/// Covariance of the determined parameters from clusters.
pub(crate) fn covariance(fit: &Settled, sums: &Sums, weights: &Weights) -> DMatrix<f64> {
    let cofactor = fit.solver.cofactor();
    let classical = &cofactor * fit.sigma_mm.max(weights.reference_mm).powi(2);
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

/// Rms of parts predicted from the others; `None` when there is only one part.
pub(crate) fn holdout(sums: &Sums) -> Option<Holdout> {
    let parts = &sums.parts;
    if parts.len() < 2 {
        return None;
    }
    let (mut squares, mut rows) = (0.0, 0);
    for (q, part) in parts.iter().enumerate() {
        let others = || parts.iter().enumerate().filter(move |(k, _)| *k != q).map(|(_, part)| part);
        let mut gram = DMatrix::zeros(part.gram.nrows(), part.gram.ncols());
        let mut score = DVector::zeros(part.score.len());
        for other in others() {
            gram += &other.gram;
            score += &other.score;
        }
        let change = solve_seen(&gram, &score);
        let plain = &part.unweighted;
        let (gram, score, of_part) = if sums.even {
            (&part.gram, &part.score, part.squares)
        } else {
            (&plain.gram, &plain.score, plain.squares)
        };
        let left = of_part - 2.0 * change.dot(score) + change.dot(&(gram * &change));
        squares += left.max(0.0);
        rows += part.rows;
    }
    Some(Holdout { rms_mm: (squares / rows as f64).sqrt(), left_out: sums.left_out, parts: parts.len() })
}

/// Solution of the normal equations in the directions they see, zero in the others.
fn solve_seen(gram: &DMatrix<f64>, score: &DVector<f64>) -> DVector<f64> {
    if score.is_empty() {
        return score.clone();
    }
    let scale = gram.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 1.0 });
    let scaled = DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, j| gram[(i, j)] * scale[i] * scale[j]);
    let eigen = scaled.symmetric_eigen();
    let least = eigen.eigenvalues.amax() * UNSEEN;
    let mut along = eigen.eigenvectors.tr_mul(&score.component_mul(&scale));
    for (x, lambda) in along.iter_mut().zip(eigen.eigenvalues.iter()) {
        *x = if *lambda > least { *x / lambda } else { 0.0 };
    }
    (eigen.eigenvectors * along).component_mul(&scale)
}
