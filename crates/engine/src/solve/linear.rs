//! Rank-revealing linear least squares on scaled columns.
//!
//! min ‖A x − b‖.  Columns are scaled by powers of two to norms near one (exact), `A S = Q R`. Everything after that
//! (rank, null space, subsets of columns, covariance) works on the small triangle R: `A_F = Q R_F` for any subset F of columns.
//! Long designs are not held in memory: `G = S AᵀA S = V Λ Vᵀ` gives `R = Λ^½ Vᵀ` (docs/design/numerics.md §1.2); the
//! Gauss–Newton steps, which compute the residual again from the data, are the refinement.
//! Limits: the Gram form sees directions down to 3·10⁻⁷ of the largest singular value, the triangle down to 10⁻¹⁴.

use nalgebra::{DMatrix, DVector, Dyn};

/// Smallest relative singular value that a Gram matrix in double precision can distinguish from zero.
const GRAM_FLOOR: f64 = 3e-7;

/// Columns smaller than this share of the largest are rounding.
const ROUNDING: f64 = 1e-13;

/// Passes of refinement after the first solution.
const REFINEMENTS: usize = 3;

/// A design reduced to its triangle.
pub(crate) struct Reduced {
    /// S: column j of the scaled design is column j of A times this.
    pub scale: DVector<f64>,
    /// R, columns × columns; below it the rows of priors.
    pub triangle: DMatrix<f64>,
    /// Smallest relative singular value that means something.
    pub floor: f64,
    form: Form,
}

enum Form {
    Orthogonal(nalgebra::linalg::QR<f64, Dyn, Dyn>),
    /// Λ^−½ Vᵀ S.
    Gram(DMatrix<f64>),
}

impl Reduced {
    /// From the design itself.
    pub fn from_design(design: &DMatrix<f64>) -> Self {
        let (rows, columns) = design.shape();
        let scale = scales(&DVector::from_iterator(columns, design.column_iter().map(|c| c.norm())));
        let mut scaled = design.clone().resize_vertically(rows.max(columns), 0.0);
        for j in 0..columns {
            scaled.column_mut(j).scale_mut(scale[j]);
        }
        let qr = scaled.qr();
        Self { scale, triangle: qr.r(), floor: 1e-14, form: Form::Orthogonal(qr) }
    }

    /// From AᵀA.
    pub fn from_gram(gram: &DMatrix<f64>) -> Self {
        let scale = scales(&gram.diagonal().map(|square| square.max(0.0).sqrt()));
        let scaled = DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, j| gram[(i, j)] * scale[i] * scale[j]);
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.amax();
        let root = eigen.eigenvalues.map(|lambda| lambda.max(0.0).sqrt());
        let least = largest.sqrt() * GRAM_FLOOR;
        let v_t = eigen.eigenvectors.transpose();
        let triangle = DMatrix::from_diagonal(&root) * &v_t;
        let inverse_root = root.map(|r| if r > least { r.recip() } else { 0.0 });
        let form = Form::Gram(DMatrix::from_diagonal(&inverse_root) * v_t * DMatrix::from_diagonal(&scale));
        Self { scale, triangle, floor: GRAM_FLOOR, form }
    }

    /// Adds a row `weight · x_j = …` for each prior; [`Solver::solve`] then wants their right-hand sides below Qᵀb.
    pub fn add_priors(&mut self, weights: &[(usize, f64)]) {
        let top = self.triangle.nrows();
        let triangle = std::mem::replace(&mut self.triangle, DMatrix::zeros(0, 0));
        self.triangle = triangle.resize_vertically(top + weights.len(), 0.0);
        for (k, &(j, weight)) in weights.iter().enumerate() {
            self.triangle[(top + k, j)] = weight * self.scale[j];
        }
    }

    /// True when [`Self::project`] wants the right-hand side itself, false when it wants Aᵀb.
    pub fn wants_rows(&self) -> bool {
        matches!(self.form, Form::Orthogonal(_))
    }

    /// Qᵀb from b, or from Aᵀb in Gram form.
    pub fn project(&self, right: &DVector<f64>) -> DVector<f64> {
        match &self.form {
            Form::Orthogonal(qr) => {
                let mut right = right.clone().resize_vertically(right.len().max(self.triangle.ncols()), 0.0);
                qr.q_tr_mul(&mut right);
                right.rows(0, self.triangle.ncols()).into_owned()
            }
            Form::Gram(projection) => projection * right,
        }
    }

    /// Singular values (falling) and right singular vectors (columns) of the scaled columns `of`.
    pub fn singular(&self, of: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
        let (sigma, v_t) = Self::singular_of(self.triangle.select_columns(of));
        (sigma, v_t.transpose())
    }

    /// Singular values (falling) and right singular vectors (rows) of a matrix with no more columns than rows.
    pub fn singular_of(matrix: DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let svd = matrix.svd(false, true);
        (svd.singular_values, svd.v_t.expect("asked for"))
    }

    /// T with A T orthonormal: the directions with a singular value above `tolerance` of the largest. T Tᵀ Aᵀ b solves
    /// min ‖A x − b‖ in the directions that A sees, with zero in the others.
    pub fn orthonormal(&self, tolerance: f64) -> DMatrix<f64> {
        let all: Vec<usize> = (0..self.scale.len()).collect();
        if all.is_empty() {
            return DMatrix::zeros(0, 0);
        }
        let (sigma, v) = self.singular(&all);
        let kept: Vec<usize> =
            all.into_iter().filter(|&k| sigma[k] > 0.0 && sigma[k] > tolerance * sigma[0]).collect();
        let mut turn = DMatrix::from_diagonal(&self.scale) * v.select_columns(&kept);
        for (mut direction, &k) in turn.column_iter_mut().zip(&kept) {
            direction.unscale_mut(sigma[k]);
        }
        turn
    }

    /// Solver for the columns `of`, which must be independent.
    pub fn solver(&self, of: &[usize]) -> Solver {
        let scale = DVector::from_iterator(of.len(), of.iter().map(|&j| self.scale[j]));
        Solver { scale, qr: self.triangle.select_columns(of).qr() }
    }
}

/// Least squares for independent columns.
pub(crate) struct Solver {
    scale: DVector<f64>,
    qr: nalgebra::linalg::QR<f64, Dyn, Dyn>,
}

impl Solver {
    /// x from Qᵀb.
    pub fn solve(&self, projected: &DVector<f64>) -> DVector<f64> {
        let mut right = projected.clone();
        self.qr.q_tr_mul(&mut right);
        let top = right.rows(0, self.scale.len()).into_owned();
        let scaled = self.qr.r().solve_upper_triangular(&top).expect("columns are independent");
        scaled.component_mul(&self.scale)
    }

    /// ‖A x‖ of a direction whose scaled parameters have length 1.
    pub fn seen(&self, x: &DVector<f64>) -> f64 {
        let scaled = x.component_div(&self.scale);
        (self.qr.r() * &scaled).norm() / scaled.norm()
    }

    /// x from Qᵀb with the scaled step held back: min ‖R y − Qᵀb‖² + damping² ‖y‖² (Levenberg, Marquardt).
    pub fn solve_damped(&self, projected: &DVector<f64>, damping: f64) -> DVector<f64> {
        if damping == 0.0 {
            return self.solve(projected);
        }
        let mut right = projected.clone();
        self.qr.q_tr_mul(&mut right);
        let n = self.scale.len();
        let mut stacked = self.qr.r().resize_vertically(2 * n, 0.0);
        stacked.view_mut((n, 0), (n, n)).fill_diagonal(damping);
        let mut right = right.rows(0, n).into_owned().resize_vertically(2 * n, 0.0);
        let qr = stacked.qr();
        qr.q_tr_mul(&mut right);
        let top = right.rows(0, n).into_owned();
        let scaled = qr.r().solve_upper_triangular(&top).expect("damped columns are independent");
        scaled.component_mul(&self.scale)
    }

    /// (AᵀA)⁻¹.
    pub fn cofactor(&self) -> DMatrix<f64> {
        let n = self.scale.len();
        let inverse =
            self.qr.r().solve_upper_triangular(&DMatrix::identity(n, n)).expect("columns are independent");
        let scaled = DMatrix::from_diagonal(&self.scale) * inverse;
        &scaled * scaled.transpose()
    }
}

/// Result of [`least_squares`].
#[derive(Clone, Debug)]
pub struct LinearFit {
    /// Coefficients; zero for columns that depend on others.
    pub x: DVector<f64>,
    /// Standard uncertainties of `x`.
    pub u: DVector<f64>,
    /// Residual standard deviation.
    pub s: f64,
    /// (AᵀA)⁻¹, zero in the rows of columns that depend on others: times s² the covariance of `x`; times 1 when rows and
    /// readings were divided by known standard uncertainties.
    pub cofactor: DMatrix<f64>,
    /// Rank.
    pub rank: usize,
}

/// min ‖A x − b‖, refined. `tolerance`: relative singular value below which a direction is not seen; dependent
/// columns, last first, get zero.
///
/// Refinement of x and r together (Björck): `r + A x = b`, `Aᵀ r = 0`; what both leave is formed in doubled precision and
/// sent through the same QR again.
pub fn least_squares(a: &DMatrix<f64>, b: &DVector<f64>, tolerance: f64) -> LinearFit {
    let of = independent_columns(a, tolerance);
    let chosen = a.select_columns(&of);
    let reduced = Reduced::from_design(&chosen);
    let scaled = &chosen * DMatrix::from_diagonal(&reduced.scale);
    let qr = scaled.clone().resize_vertically(a.nrows().max(of.len()), 0.0).qr();
    let (q, triangle) = (qr.q().rows(0, a.nrows()).into_owned(), qr.r());
    let (mut z, mut r) = (DVector::<f64>::zeros(of.len()), DVector::<f64>::zeros(b.len()));
    let scaled_t = scaled.transpose();
    for _ in 0..=REFINEMENTS {
        let f = DVector::from_fn(b.len(), |i, _| {
            doubled_sum(b[i], [(1.0, -r[i])].into_iter().chain(products(&scaled, i, &z)))
        });
        let g = DVector::from_fn(of.len(), |j, _| doubled_sum(0.0, products(&scaled_t, j, &r)));
        let p = triangle.tr_solve_upper_triangular(&g).expect("columns are independent");
        let c = q.tr_mul(&f);
        z += triangle.solve_upper_triangular(&(&c - &p)).expect("columns are independent");
        r += &q * p + f - &q * c;
    }
    let degrees_of_freedom = a.nrows().saturating_sub(of.len()).max(1);
    let s = (r.norm_squared() / degrees_of_freedom as f64).sqrt();
    let all: Vec<usize> = (0..of.len()).collect();
    let small = reduced.solver(&all).cofactor();
    let mut x = DVector::zeros(a.ncols());
    let mut cofactor = DMatrix::zeros(a.ncols(), a.ncols());
    for (k, &j) in of.iter().enumerate() {
        x[j] = z[k] * reduced.scale[k];
        for (l, &i) in of.iter().enumerate() {
            cofactor[(j, i)] = small[(k, l)];
        }
    }
    let u = cofactor.diagonal().map(|q| s * q.sqrt());
    LinearFit { x, u, s, cofactor, rank: of.len() }
}

fn independent_columns(a: &DMatrix<f64>, tolerance: f64) -> Vec<usize> {
    let reduced = Reduced::from_design(a);
    let mut of: Vec<usize> = (0..a.ncols()).collect();
    while of.len() > 1 {
        let (sigma, v) = reduced.singular(&of);
        let last = of.len() - 1;
        if sigma[last] > tolerance * sigma[0] {
            break;
        }
        let drop = (0..of.len()).rev().find(|&i| v[(i, last)].abs() > 1e-6).unwrap_or(last);
        of.remove(drop);
    }
    of
}

/// −A_ij x_j of row i.
fn products<'a>(a: &'a DMatrix<f64>, i: usize, x: &'a DVector<f64>) -> impl Iterator<Item = (f64, f64)> + 'a {
    (0..x.len()).map(move |j| (-a[(i, j)], x[j]))
}

/// `start` plus all products, summed in doubled precision (two-product by fused multiply-add, two-sum).
fn doubled_sum(start: f64, products: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (mut high, mut low) = (start, 0.0);
    for (a, b) in products {
        let product = a * b;
        low += a.mul_add(b, -product);
        let sum = high + product;
        let back = sum - high;
        low += (high - (sum - back)) + (product - back);
        high = sum;
    }
    high + low
}

/// The power of two nearest to 1/norm for each column; 1 for one that is rounding only, which must not pass for a direction
/// that is seen (a ball bar's column of a motion across it).
fn scales(norms: &DVector<f64>) -> DVector<f64> {
    let rounding = ROUNDING * norms.iter().copied().filter(|norm| norm.is_finite()).fold(0.0, f64::max);
    norms.map(|norm| if norm > rounding && norm.is_finite() { (-norm.log2().round()).exp2() } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_rounding_is_not_seen() {
        let design = DMatrix::from_fn(40, 3, |i, j| {
            let t = i as f64 * 0.37;
            [150.0 * t.sin(), t.cos(), 3e-15 * (5.0 * t).sin()][j]
        });
        for reduced in [Reduced::from_design(&design), Reduced::from_gram(&(design.transpose() * &design))] {
            let (sigma, v) = reduced.singular(&[0, 1, 2]);
            assert!(sigma[2] < 1e-12 * sigma[0], "{sigma}");
            assert!(v[(2, 2)].abs() > 0.99);
        }
        assert_eq!(least_squares(&design, &design.column(0).into_owned(), 1e-8).rank, 2);
    }
}
