//! The covariance at one choice of sizes, and what projections on it give.

use super::Real;
use super::dense;
use super::kernel::Over;
use super::kernels::Kernels;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// Above this sum of ρ² single precision no longer holds the factor: rounding grows with it, the white part stays 1.
const SINGLE_PRECISION: f64 = 12.0;
/// White variance of a point that is worth nothing, as a multiple.
pub(crate) const NOTHING: f64 = 1e4;

/// Σ⁻¹ and ln det Σ at x = (ln s, ln ρ_k).
pub(crate) struct Sigma {
    pub x: Vec<f64>,
    /// Root mean square of the white standard deviations of all rows.
    pub white: f64,
    pub inverse: DMatrix<Real>,
    /// Rows that say something.
    pub rows: usize,
    /// But for a constant: of rows that say nothing the variance is the same, whatever s is.
    log_det: f64,
}

impl Sigma {
    /// `white`: multiple of the white variance of every row. `None` where rounding makes Σ indefinite.
    pub fn new(kernels: &Kernels, x: &[f64], white: &DVector<f64>) -> Option<Self> {
        let rho_squared: Vec<f64> = x[1..].iter().map(|ln| (2.0 * ln).exp()).collect();
        let squares = |is_white: bool| {
            let own =
                kernels.list.iter().zip(&rho_squared).filter(|(kernel, _)| kernel.is_white() == is_white);
            own.map(|(_, square)| square).sum::<f64>()
        };
        let mut relative = covariance(kernels, &rho_squared, white);
        let (log_det, mut inverse) = if squares(false) < SINGLE_PRECISION {
            (dense::factor(&mut relative)?, dense::inverse(relative)?)
        } else {
            // To the end: what the kernels explain nearly all of has a small share in the inverse.
            let mut relative = relative.cast::<f64>();
            (dense::factor(&mut relative)?, dense::inverse(relative)?.cast::<Real>())
        };
        let rows = white.iter().filter(|white| **white < NOTHING).count();
        inverse *= (-2.0 * x[0]).exp() as Real;
        let white = x[0].exp() * (1.0 + squares(true)).sqrt();
        Some(Self { x: x.to_vec(), white, inverse, rows, log_det: log_det + 2.0 * rows as f64 * x[0] })
    }
}

/// W + Σ_k ρ_k² K_k: the lower triangle; above it only what is of the same point.
fn covariance(kernels: &Kernels, rho_squared: &[f64], white: &DVector<f64>) -> DMatrix<Real> {
    let (rows, points) = (kernels.point_of_row.len(), kernels.points);
    let mut sums: Vec<Option<DMatrix<Real>>> = vec![None; kernels.frames.len()];
    let mut own = vec![0.0; kernels.frames.len()];
    for (kernel, rho) in kernels.list.iter().zip(rho_squared) {
        match &kernel.over {
            Over::Own => own[kernel.frame] += *rho as Real,
            Over::Pairs(pairs) => {
                let sum = sums[kernel.frame].get_or_insert_with(|| DMatrix::zeros(points, points));
                let rho = *rho as Real;
                for (a, b) in sum.as_mut_slice().iter_mut().zip(pairs.as_slice()) {
                    *a += rho * b;
                }
            }
        }
    }
    let (mut sigma, mut gram) = (DMatrix::zeros(rows, rows), Vec::new());
    for column in 0..rows {
        let point = kernels.point_of_row[column];
        let Range { start: first, end: last } = kernels.rows_of_point[point];
        let target = &mut sigma.as_mut_slice()[column * rows + first..(column + 1) * rows];
        for ((frame, sum), own) in kernels.frames.iter().zip(&sums).zip(&own) {
            // Of a kernel of single points only what is of the same point.
            let end = if sum.is_some() { rows } else { last };
            if sum.is_some() || *own > 0.0 {
                frame.gram(column, first..end, &mut gram);
            }
            if let Some(sum) = sum {
                let of_points = &sum.as_slice()[point * points..(point + 1) * points];
                kernels.add_expanded(point, target, &gram, of_points);
            }
            for row in (column..last).filter(|_| *own > 0.0) {
                target[row - first] += own * gram[row - first];
            }
        }
        target[column - first] += white[column] as Real;
    }
    sigma
}

/// Readings with columns X projected out, at one Σ.
#[derive(Clone)]
pub(crate) struct Projected {
    pub sigma: Arc<Sigma>,
    /// Σ⁻¹X.
    pub weighted: DMatrix<Real>,
    /// (XᵀΣ⁻¹X)⁻¹.
    pub cofactor: DMatrix<f64>,
    /// Py.
    pub py: DVector<Real>,
    /// yᵀPy.
    pub quadratic: f64,
    /// −½ (ln|Σ| + ln|XᵀΣ⁻¹X| + yᵀPy).
    pub likelihood: f64,
}

impl Projected {
    /// `basis`: orthonormal columns X.
    pub fn new(sigma: Arc<Sigma>, y: &DVector<Real>, basis: &DMatrix<Real>) -> Option<Self> {
        let weighted = &sigma.inverse * basis;
        let gram = (basis.transpose() * &weighted).cast::<f64>();
        let factor = ((&gram + gram.transpose()) * 0.5).cholesky()?;
        let log_det = factor.ln_determinant();
        let cofactor = factor.inverse();
        let on_basis = weighted.tr_mul(y).cast::<f64>();
        let py = &sigma.inverse * y - &weighted * (&cofactor * on_basis).cast::<Real>();
        let quadratic = y.iter().zip(py.iter()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
        let likelihood = -0.5 * (sigma.log_det + log_det + quadratic);
        Some(Self { sigma, weighted, cofactor, py, quadratic, likelihood })
    }

    /// P.
    pub fn precision(&self) -> DMatrix<Real> {
        let mut precision = self.sigma.inverse.clone();
        let right = self.cofactor.map(|x| x as Real) * self.weighted.transpose();
        precision.gemm(-1.0, &self.weighted, &right, 1.0);
        precision
    }

    /// AᵀPA of several blocks of columns side by side (rows × columns), one Gram matrix for each width.
    pub fn grams(&self, columns: &DMatrix<Real>, widths: &[usize]) -> Vec<DMatrix<f64>> {
        let seen = &self.sigma.inverse * columns;
        let on_basis = (self.weighted.transpose() * columns).cast::<f64>();
        let mut first = 0;
        let gram = |&width: &usize| {
            let (a, b) = (columns.columns(first, width), seen.columns(first, width));
            let shadow = on_basis.columns(first, width);
            first += width;
            a.tr_mul(&b).cast::<f64>() - shadow.transpose() * &self.cofactor * shadow
        };
        widths.iter().map(gram).collect()
    }
}
