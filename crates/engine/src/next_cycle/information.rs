//! What a set of runs can show of several effects: their columns under a few noise models, the model projected out.
//!
//! `S = CᵀΣ⁻¹C − CᵀΣ⁻¹X (XᵀΣ⁻¹X)⁺ XᵀΣ⁻¹C`, X the columns of the model, C those of the effects [docs/design/statistics.md §2: what the model can
//! imitate scores nothing]. Everything that follows is small linear algebra on S.

use crate::Experiment;
use crate::noise::machine_noise::{Noise, Order, Whitener};
use crate::problem::credible::credible_columns;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use trunnion_effects::Instance;

/// A direction that keeps less than this share of its norm is imitated by others.
pub(super) const SURVIVAL: f64 = 0.03;
/// Directions of the model below this share (squared) of the largest are not seen.
const MODEL_NULL: f64 = 1e-10;

/// Noise models over which a plan averages: white, re-positioning, drift, and all of them.
const NOISES: [(f64, f64, f64); 4] = [(0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.0, 0.0, 0.5), (0.4, 0.08, 0.5)];

/// One effect at one shape.
#[derive(Clone, Debug)]
pub(super) struct Part<'a> {
    pub instance: &'a Instance,
    pub shape: Vec<f64>,
}

impl Part<'_> {
    /// Its columns; none where the scene cannot have it, zero where it moves nothing at any credible size.
    pub fn columns(&self, experiment: &Experiment) -> DMatrix<f64> {
        credible_columns(experiment, self.instance, &self.shape)
    }
}

/// The effects' columns under every noise model.
pub(super) struct Information {
    /// Columns of each part in the matrices.
    pub parts: Vec<Range<usize>>,
    /// One for each noise model.
    pub views: Vec<View>,
    /// Scalar readings.
    pub rows: usize,
}

/// The effects' columns under one noise model, white noise of unit variance.
pub(super) struct View {
    /// S; the readings, where given, are the last column.
    pub products: DMatrix<f64>,
    /// Squared norms of the whitened columns before projection.
    pub norms: DVector<f64>,
    /// ln det Σ/σ².
    pub log_det: f64,
    /// Parameters of the model that the runs can see.
    pub rank: usize,
}

impl Information {
    /// Columns of `model` are projected out; `readings`, if any, are whatever the model left of them.
    pub fn new(
        experiment: &Experiment,
        model: &DMatrix<f64>,
        parts: &[Part<'_>],
        readings: Option<&DVector<f64>>,
    ) -> Self {
        let mut ranges = Vec::with_capacity(parts.len());
        let mut blocks = Vec::with_capacity(parts.len() + 1);
        let mut next = 0;
        for part in parts {
            let columns = part.columns(experiment);
            ranges.push(next..next + columns.ncols());
            next += columns.ncols();
            blocks.push(columns);
        }
        blocks.extend(readings.map(|y| DMatrix::from_column_slice(y.len(), 1, y.as_slice())));
        // Held transposed: that is how a filter runs over time.
        let total = model.ncols() + blocks.iter().map(DMatrix::ncols).sum::<usize>();
        let mut all = DMatrix::zeros(total, experiment.rows());
        let mut at = 0;
        for block in std::iter::once(model).chain(&blocks) {
            all.rows_mut(at, block.ncols()).tr_copy_from(block);
            at += block.ncols();
        }
        let order = Order::new(experiment);
        let view = |&(pass, axis, drift): &(f64, f64, f64)| {
            let whitener = Whitener::new(&order, &Noise { pass, axis, drift, tau: order.tau });
            let mut whitened = all.clone();
            whitener.whiten(&mut whitened);
            let gram = &whitened * whitened.transpose();
            let (products, rank) = project_out(&gram, model.ncols());
            let norms = gram.diagonal().rows(model.ncols(), total - model.ncols()).into_owned();
            View { products, norms, log_det: whitener.log_det, rank }
        };
        Self { parts: ranges, views: NOISES.iter().map(view).collect(), rows: experiment.rows() }
    }
}

impl View {
    /// Products of two parts.
    pub fn between(&self, a: &Range<usize>, b: &Range<usize>) -> DMatrix<f64> {
        self.products.view((a.start, b.start), (a.len(), b.len())).into_owned()
    }

    /// What is left of part `a` when part `b` may imitate it.
    pub fn left_by(&self, a: &Range<usize>, b: Option<&Range<usize>>) -> DMatrix<f64> {
        let own = self.between(a, a);
        let Some(b) = b else { return own };
        let across = self.between(a, b);
        let inverse = self.inverse(b);
        own - &across * inverse * across.transpose()
    }

    /// Inverse of a part's own products within what survives of it.
    pub fn inverse(&self, part: &Range<usize>) -> DMatrix<f64> {
        let root = self.inverse_root(part);
        &root * root.transpose()
    }

    /// R with Rᵀ S R = 1 on the surviving directions of a part (parameter × direction).
    pub fn inverse_root(&self, part: &Range<usize>) -> DMatrix<f64> {
        if part.is_empty() {
            return DMatrix::zeros(0, 0);
        }
        let scale: DVector<f64> = self.norms.rows(part.start, part.len()).map(|n| 1.0 / n.sqrt().max(1e-150));
        let scaled = DMatrix::from_fn(part.len(), part.len(), |i, j| {
            scale[i] * self.products[(part.start + i, part.start + j)] * scale[j]
        });
        let eigen = scaled.symmetric_eigen();
        let kept: Vec<usize> =
            (0..part.len()).filter(|&j| eigen.eigenvalues[j] > SURVIVAL * SURVIVAL).collect();
        DMatrix::from_fn(part.len(), kept.len(), |i, j| {
            scale[i] * eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
        })
    }

    /// Canonical correlations of the surviving directions of two parts, largest first.
    pub fn correlations(&self, a: &Range<usize>, b: &Range<usize>) -> Vec<f64> {
        let (root_a, root_b) = (self.inverse_root(a), self.inverse_root(b));
        if root_a.ncols() == 0 || root_b.ncols() == 0 {
            return Vec::new();
        }
        let mut values: Vec<f64> =
            (root_a.transpose() * self.between(a, b) * root_b).singular_values().iter().copied().collect();
        values.sort_by(|x, y| y.total_cmp(x));
        values
    }

    /// Share of the readings' square that a part explains.
    pub fn explained(&self, part: &Range<usize>) -> f64 {
        let on_readings = self.on_readings(part);
        (on_readings.transpose() * self.inverse(part) * on_readings)[(0, 0)]
    }

    /// Least-squares values of a part, zero in what does not survive.
    pub fn values(&self, part: &Range<usize>) -> DVector<f64> {
        self.inverse(part) * self.on_readings(part)
    }

    /// Square of what the model left of the readings.
    pub fn readings_squared(&self) -> f64 {
        let last = self.products.nrows() - 1;
        self.products[(last, last)]
    }

    fn on_readings(&self, part: &Range<usize>) -> DVector<f64> {
        let last = self.products.nrows() - 1;
        self.products.view((part.start, last), (part.len(), 1)).column(0).into_owned()
    }
}

/// S and the rank of the first `model` columns.
fn project_out(gram: &DMatrix<f64>, model: usize) -> (DMatrix<f64>, usize) {
    let others = gram.nrows() - model;
    let scale: Vec<f64> = (0..model).map(|j| 1.0 / gram[(j, j)].sqrt().max(1e-150)).collect();
    let own = DMatrix::from_fn(model, model, |i, j| scale[i] * gram[(i, j)] * scale[j]);
    let across = DMatrix::from_fn(model, others, |i, j| scale[i] * gram[(i, model + j)]);
    let eigen = own.symmetric_eigen();
    let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let kept: Vec<usize> = (0..model).filter(|&j| eigen.eigenvalues[j] > MODEL_NULL * largest).collect();
    let basis = DMatrix::from_fn(model, kept.len(), |i, j| {
        eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt()
    });
    let shadow = basis.transpose() * across;
    let products = gram.view((model, model), (others, others)) - shadow.transpose() * shadow;
    (products, kept.len())
}

/// A column that is no number anywhere is no column.
pub(super) fn finite(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        if column.iter().any(|x| !x.is_finite()) {
            column.fill(0.0);
        }
    }
    columns
}
