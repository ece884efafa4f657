//! The covariance at one choice of sizes, and what projections on it give.

use super::Real;
use super::dense;
use super::kernels::{Kernels, Over};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Above this sum of ρ² single precision no longer holds the factor: rounding grows with it, the white part stays 1.
const SINGLE_PRECISION: f64 = 12.0;

/// Σ⁻¹ and ln det Σ at x = (ln s, ln ρ_k).
pub(crate) struct Sigma {
    pub x: Vec<f64>,
    pub inverse: DMatrix<Real>,
    log_det: f64,
    contracted: OnceLock<Vec<DMatrix<Real>>>,
}

impl Sigma {
    /// `white`: multiple of the white variance of every row. `None` where rounding makes Σ indefinite.
    pub fn new(kernels: &Kernels, x: &[f64], white: &DVector<f64>) -> Option<Self> {
        let rho_squared: Vec<f64> = x[1..].iter().map(|ln| (2.0 * ln).exp()).collect();
        let mut relative = covariance(kernels, &rho_squared, white);
        let (log_det, mut inverse) = if rho_squared.iter().sum::<f64>() < SINGLE_PRECISION {
            (dense::factor(&mut relative)?, dense::inverse(relative)?)
        } else {
            // To the end: what the kernels explain nearly all of has a small share in the inverse.
            let mut relative = relative.cast::<f64>();
            (dense::factor(&mut relative)?, dense::inverse(relative)?.cast::<Real>())
        };
        let rows = inverse.nrows() as f64;
        inverse *= (-2.0 * x[0]).exp() as Real;
        let (log_det, contracted) = (log_det + 2.0 * rows * x[0], OnceLock::new());
        Some(Self { x: x.to_vec(), inverse, log_det, contracted })
    }

    /// Of Σ⁻¹ in every frame of its kernels, [`Kernels::contracted`].
    fn contracted(&self, kernels: &Kernels) -> &[DMatrix<Real>] {
        let of_frame = |frame| kernels.contracted(frame, &self.inverse);
        self.contracted.get_or_init(|| (0..kernels.frames.len()).map(of_frame).collect())
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
                for point in 0..points {
                    let below = point * points + point..(point + 1) * points;
                    let target = &mut sum.as_mut_slice()[below.clone()];
                    for (a, b) in target.iter_mut().zip(&pairs.as_slice()[below]) {
                        *a += rho * b;
                    }
                }
            }
        }
    }
    let mut sigma = DMatrix::zeros(rows, rows);
    let mut of_rows = vec![0.0; rows];
    for (point, Range { start: first, end: last }) in kernels.rows_of_point.iter().cloned().enumerate() {
        for (frame, sum) in kernels.frames.iter().zip(&sums) {
            let Some(sum) = sum else { continue };
            let of_rows = &mut of_rows[first..];
            kernels.spread(point, &sum.as_slice()[point * points..(point + 1) * points], of_rows);
            for column in first..last {
                let below = column * rows + first..(column + 1) * rows;
                let gram = &frame.gram.as_slice()[below.clone()];
                let target = &mut sigma.as_mut_slice()[below];
                for ((value, gram), of_row) in target.iter_mut().zip(gram).zip(&*of_rows) {
                    *value += gram * of_row;
                }
            }
        }
        for column in first..last {
            for (frame, own) in kernels.frames.iter().zip(&own).filter(|(_, own)| **own > 0.0) {
                for row in column..last {
                    sigma[(row, column)] += own * frame.gram[(row, column)];
                }
            }
            sigma[(column, column)] += white[column] as Real;
        }
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
        let log_det: f64 = factor.l_dirty().diagonal().iter().map(|d| 2.0 * d.ln()).sum();
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

    /// Diagonal of P.
    pub fn precision_diagonal(&self) -> DVector<Real> {
        let right = &self.weighted * self.cofactor.map(|x| x as Real);
        let mut diagonal = self.sigma.inverse.diagonal();
        for (right, weighted) in right.column_iter().zip(self.weighted.column_iter()) {
            diagonal -= right.component_mul(&weighted);
        }
        diagonal
    }

    /// P times columns.
    pub fn seen(&self, columns: &DMatrix<Real>) -> DMatrix<Real> {
        let on_basis = &self.cofactor * self.weighted.tr_mul(columns).cast::<f64>();
        let mut seen = &self.sigma.inverse * columns;
        seen.gemm(-1.0, &self.weighted, &on_basis.cast::<Real>(), 1.0);
        seen
    }

    /// Of P in every frame of the kernels, [`Kernels::contracted`]: that of Σ⁻¹ without what the columns take, folded to points.
    pub fn contracted(&self, kernels: &Kernels) -> Vec<DMatrix<Real>> {
        let cofactor = self.cofactor.map(|x| x as Real);
        let of_frame = |(frame, of_inverse): (usize, &DMatrix<Real>)| {
            let mut contracted = of_inverse.clone();
            for folded in kernels.folded_columns(&kernels.frames[frame], &self.weighted) {
                let right = &folded * &cofactor;
                if kernels.is_own(frame) {
                    for point in 0..kernels.points {
                        contracted[(point, point)] -= right.row(point).dot(&folded.row(point));
                    }
                } else {
                    contracted.gemm(-1.0, &right, &folded.transpose(), 1.0);
                }
            }
            contracted
        };
        self.sigma.contracted(kernels).iter().enumerate().map(of_frame).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evidence::orthonormal;
    use crate::noise::learned::kernels::points::tests::kernels;

    #[test]
    fn what_is_found_without_the_projection_is_what_it_gives() {
        for rows_of_points in [vec![3; 9], vec![3, 1, 3, 3, 1, 3, 1, 1, 3]] {
            let kernels = kernels(&rows_of_points);
            let rows = kernels.point_of_row.len();
            let white = DVector::from_fn(rows, |i, _| 1.0 + (i % 3) as f64);
            let sigma = Sigma::new(&kernels, &[0.1, -1.0, -2.0], &white).map(Arc::new).unwrap();
            let columns = |count, start: usize| {
                DMatrix::from_fn(rows, count, |i, j| ((start + 3 * i * (j + 1) + i * i) % 17) as f64 - 8.0)
            };
            let y: DVector<Real> = columns(1, 5).column(0).into_owned().cast();
            let here = Projected::new(sigma, &y, &orthonormal(&columns(4, 0)).cast()).unwrap();
            let precision = here.precision();
            let size = precision.amax();
            assert!((here.precision_diagonal() - precision.diagonal()).amax() < 1e-5 * size);
            let others: DMatrix<Real> = columns(6, 2).cast();
            let seen = &precision * &others;
            assert!((here.seen(&others) - &seen).amax() < 1e-5 * seen.amax());
            for (frame, contracted) in here.contracted(&kernels).iter().enumerate() {
                let plain = kernels.contracted(frame, &precision);
                assert!((contracted - &plain).amax() < 1e-4 * plain.amax(), "{contracted} {plain}");
            }
        }
    }
}
