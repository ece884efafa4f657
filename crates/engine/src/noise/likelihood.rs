//! Likelihood of the variances of a machine's noise, from the residual alone.
//!
//! ln p(y | θ, c) = −½ ln det Σ/σ² − ½ ln det AᵀΣ⁻¹A σ² − ½ ν ln rss(θ, c),   E[σ² | θ, c] = rss / (ν − 2)   (REML, σ integrated out)
//!
//! With M the projection off the columns A of the fit (after the scatter c has been whitened away) and D = diag θ:
//! ln det of both = ln det(I + D^½ Zᵀ M Z D^½) + const, rss = yᵀMy − bᵀ(I + D^½ Zᵀ M Z D^½)⁻¹ b, b = D^½ Zᵀ M y [Woodbury]: readings
//! appear only in inner products, formed once.

use crate::noise::random_columns::{Kind, Levers};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// What the variances are estimated from. Rows of readings not used are zero in all.
pub(crate) struct Residual<'a> {
    /// Columns of the fit, weighted.
    pub fitted: &'a DMatrix<f64>,
    /// Weighted residual, mm.
    pub residual_mm: &'a DVector<f64>,
    /// Random columns.
    pub kinds: &'a [Kind],
    /// Scatter of the fast axis.
    pub levers: &'a Levers,
    /// Readings used minus parameters determined, more than 2.
    pub degrees_of_freedom: usize,
}

/// A part of which the readings show fewer directions than this, after the fit took its share, cannot be sized.
const FEWEST_DIRECTIONS: usize = 3;
/// A direction counts as seen when its part of the variance, for a part as large as the white noise, exceeds the white noise of one
/// reading: eigenvalues of ZᵀMZ above 1. A share of the largest eigenvalue would ask more of a part whose largest directions the fit
/// takes, as temperatures take slow drift.
const SEEN: f64 = 1.0;

/// Inner products of X = [Q Z y], Q an orthonormal basis of the fitted columns.
pub(crate) struct Products {
    /// XᵀX.
    gram: DMatrix<f64>,
    /// LᵀX.
    levers: DMatrix<f64>,
    /// Diagonal of LᵀL.
    pub squares: DVector<f64>,
    fitted: usize,
    pub kinds: Vec<SizedKind>,
    /// Kinds asked for, also those that cannot be sized.
    pub given: usize,
    degrees_of_freedom: f64,
}

/// A kind that these readings can size.
pub(crate) struct SizedKind {
    /// Its number among those asked for.
    pub given: usize,
    columns: usize,
}

impl Products {
    pub fn new(residual: &Residual<'_>) -> Self {
        let q = orthonormal(residual.fitted);
        let (mut kinds, mut random) = (Vec::new(), Vec::new());
        for (given, kind) in residual.kinds.iter().enumerate() {
            if directions_seen(&q, &kind.columns) >= FEWEST_DIRECTIONS {
                kinds.push(SizedKind { given, columns: kind.columns.ncols() });
                random.push(&kind.columns);
            }
        }
        let width = q.ncols() + random.iter().map(|columns| columns.ncols()).sum::<usize>() + 1;
        let mut x = DMatrix::zeros(q.nrows(), width);
        x.columns_mut(0, q.ncols()).copy_from(&q);
        let mut next = q.ncols();
        for columns in random {
            x.columns_mut(next, columns.ncols()).copy_from(columns);
            next += columns.ncols();
        }
        x.set_column(next, residual.residual_mm);
        Self {
            // By the blocked product: the transposed one of nalgebra goes column by column.
            gram: x.transpose() * &x,
            levers: residual.levers.seen_by(&x),
            squares: residual.levers.squares(),
            fitted: q.ncols(),
            kinds,
            given: residual.kinds.len(),
            degrees_of_freedom: residual.degrees_of_freedom as f64,
        }
    }

    /// With the scatter c of the fast axis whitened away, (I + c L Lᵀ)⁻¹ = I − L diag(c/(1 + c l²)) Lᵀ, and M applied.
    pub fn project(&self, c: f64) -> Projected {
        let mut weighted = self.levers.clone();
        let shrink = self.squares.map(|square| c / (1.0 + c * square));
        weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(&shrink));
        let gram = if c > 0.0 { &self.gram - self.levers.transpose() * weighted } else { self.gram.clone() };
        let (q, rest) = (self.fitted, gram.ncols() - self.fitted);
        let of_fit = positive_definite(gram.view((0, 0), (q, q)).into_owned());
        let on_fit = of_fit
            .l_dirty()
            .solve_lower_triangular(&gram.view((0, q), (q, rest)))
            .expect("a positive diagonal");
        let left = gram.view((q, q), (rest, rest)) - on_fit.transpose() * &on_fit;
        let random = rest - 1;
        Projected {
            gram: left.view((0, 0), (random, random)).into_owned(),
            on_residual: left.view((0, random), (random, 1)).column(0).into_owned(),
            squares: left[(random, random)],
            log_det: log_det(&of_fit) + self.squares.iter().map(|square| (c * square).ln_1p()).sum::<f64>(),
        }
    }
}

/// One choice of variances.
pub(crate) struct Member {
    /// ln of its likelihood, but for a constant.
    pub ln: f64,
    /// E[σ²], mm².
    pub white: f64,
}

/// Products of the random columns and the residual, off the fitted columns.
pub(crate) struct Projected {
    /// ZᵀMZ.
    gram: DMatrix<f64>,
    /// ZᵀMy.
    on_residual: DVector<f64>,
    /// yᵀMy.
    squares: f64,
    log_det: f64,
}

impl Projected {
    /// Likelihood of one choice of θ; `theta_of` numbers the kinds that can be sized.
    pub fn member(&self, products: &Products, theta_of: impl Fn(usize) -> f64) -> Member {
        let (mut active, mut root, mut next) = (Vec::new(), Vec::new(), 0);
        for (k, kind) in products.kinds.iter().enumerate() {
            let theta = theta_of(k);
            if theta > 0.0 {
                active.extend(next..next + kind.columns);
                root.extend(std::iter::repeat_n(theta.sqrt(), kind.columns));
            }
            next += kind.columns;
        }
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let entry = |i: usize, j: usize| one(i, j) + root[i] * root[j] * self.gram[(active[i], active[j])];
        let cholesky = positive_definite(DMatrix::from_fn(active.len(), active.len(), entry));
        let b = DVector::from_fn(active.len(), |i, _| root[i] * self.on_residual[active[i]]);
        let explained =
            cholesky.l_dirty().solve_lower_triangular(&b).expect("a positive diagonal").norm_squared();
        let rss = (self.squares - explained).max(f64::MIN_POSITIVE);
        let nu = products.degrees_of_freedom;
        let ln = -0.5 * (self.log_det + log_det(&cholesky)) - 0.5 * nu * rss.ln();
        Member { ln, white: rss / (nu - 2.0) }
    }
}

/// How many directions of random columns are left off the fitted ones.
fn directions_seen(q: &DMatrix<f64>, columns: &DMatrix<f64>) -> usize {
    let left = columns - q * q.tr_mul(columns);
    left.tr_mul(&left).symmetric_eigenvalues().iter().filter(|lambda| **lambda > SEEN).count()
}

fn orthonormal(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut scaled = columns.clone();
    for mut column in scaled.column_iter_mut() {
        let norm = column.norm();
        column /= if norm > 0.0 { norm } else { 1.0 };
    }
    scaled.qr().q()
}

fn positive_definite(matrix: DMatrix<f64>) -> Cholesky<f64, Dyn> {
    matrix.cholesky().expect("identity plus a Gram matrix is positive definite")
}

fn log_det(cholesky: &Cholesky<f64, Dyn>) -> f64 {
    let l = cholesky.l_dirty();
    2.0 * (0..l.nrows()).map(|k| l[(k, k)].ln()).sum::<f64>()
}
