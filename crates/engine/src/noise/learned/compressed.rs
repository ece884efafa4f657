//! Readings compressed to the directions in which a machine moves more than it scatters. Kernels of white noise are white here, of the size at the
//! mode: what a channel scatters is known from as many readings as it has.
//!
//! z = Tᵀy,   T = P U,   TᵀX = 0,   TᵀΣ(r)T = Tᵀ(Σ̂ − Σ_k v̂_kK_k)T + Σ_k r_k Tᵀv̂_kK_kT,   r_k = v_k/v̂_k,   TᵀΣ̂T = 1
//!
//! U: the range of Σ_k (v̂_k/√d_k) K_k P Σ_k (v̂_k/√d_k) K_k on random columns [Halko 2011], d_k = n²/‖K_k‖²: of kernels of the same size those
//! of few directions come first, for they move the values of a fit. The likelihood of z is exact at any sizes, and costs a thousandth of
//! that of all readings. Of the directions left out each is taken to have the same share g_k of every kernel: w = 1 + Σ_k g_k(r_k − 1).

use super::Real;
use super::kernel::{Kernel, Over};
use super::kernels::Kernels;
use super::mode::Mode;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Intervals of a drift that looks like offsets of passes are right with 64 directions as with 96 (docs/measured/worlds.md).
const MOST_DIRECTIONS: usize = 64;
/// At most one direction for so many readings.
const READINGS_PER_DIRECTION: usize = 3;
const POWERS: usize = 2;
/// Directions that are this much smaller than the largest are rounding.
const LEAST_SIZE: f64 = 1e-5;
/// What is white of the directions left out is never less: rounding.
const LEAST_WHITE: f64 = 1e-2;

/// The compressed readings.
pub(super) struct Compressed {
    /// Tᵀ v̂_k K_k T.
    of_kernels: Vec<DMatrix<f64>>,
    of_white: DMatrix<f64>,
    z: DVector<f64>,
    rest: Rest,
}

/// The directions left out.
struct Rest {
    count: f64,
    /// Σ of the squares of the readings in them.
    square: f64,
    /// g of every kernel.
    shares: Vec<f64>,
    white: f64,
}

/// The covariance at some sizes.
pub(super) struct Here {
    factor: Cholesky<f64, Dyn>,
    /// (TᵀΣT)⁻¹z.
    solved: DVector<f64>,
    w: f64,
    pub log_likelihood: f64,
}

/// What the compressed readings say of ln ρ of some kernels.
pub(super) struct Seen {
    /// v tr PK.
    pub traces: DVector<f64>,
    /// v yᵀPKPy; the gradient of the likelihood is that less the trace.
    pub squares: DVector<f64>,
    /// Average information 2 v_kv_l yᵀPK_kPK_lPy [Gilmour 1995].
    pub information: DMatrix<f64>,
}

impl Compressed {
    /// `precision`: P.
    pub fn new(mode: &Mode, precision: &DMatrix<Real>, kernels: &Kernels, y: &DVector<Real>) -> Self {
        let of_wandering =
            |(kernel, variance): (&Kernel, f64)| if kernel.is_white() { 0.0 } else { variance };
        let variances: Vec<f64> = kernels.list.iter().zip(variances(mode)).map(of_wandering).collect();
        let rows = mode.here.sigma.rows;
        let t = directions(precision, kernels, &variances);
        let mut of_kernels = kernels.through(&t);
        of_kernels.iter_mut().zip(&variances).for_each(|(of_kernel, variance)| *of_kernel *= *variance);
        let mut of_white = DMatrix::identity(t.ncols(), t.ncols());
        of_kernels.iter().for_each(|of_kernel| of_white -= of_kernel);
        let z = t.tr_mul(y).cast::<f64>();
        let known = mode.here.weighted.ncols() + t.ncols();
        let count = rows.saturating_sub(known).max(1) as f64;
        let left = |((kernel, trace), of_kernel): ((&Kernel, &f64), &DMatrix<f64>)| {
            if kernel.is_white() { 0.0 } else { (trace - of_kernel.trace()).max(0.0) / count }
        };
        let shares: Vec<f64> = kernels.list.iter().zip(&mode.traces).zip(&of_kernels).map(left).collect();
        let white = (1.0 - shares.iter().sum::<f64>()).max(LEAST_WHITE);
        let square = (mode.here.quadratic - z.norm_squared()).max(0.0);
        Self { of_kernels, of_white, z, rest: Rest { count, square, shares, white } }
    }

    /// `ratios`: r of every kernel, 0 where there is none. `None` where rounding makes the covariance indefinite.
    pub fn at(&self, ratios: &[f64]) -> Option<Here> {
        let (mut sigma, mut w) = (self.of_white.clone(), self.rest.white);
        for ((of_kernel, share), ratio) in self.of_kernels.iter().zip(&self.rest.shares).zip(ratios) {
            if *ratio > 0.0 {
                add_lower(*ratio, of_kernel, &mut sigma);
                w += ratio * share;
            }
        }
        let factor = sigma.cholesky()?;
        let solved = factor.solve(&self.z);
        let of_rest = self.rest.count * w.ln() + self.rest.square / w;
        let log_likelihood = -0.5 * (factor.ln_determinant() + self.z.dot(&solved) + of_rest);
        Some(Here { factor, solved, w, log_likelihood })
    }

    /// `chosen`: numbers of kernels.
    pub fn seen(&self, here: &Here, ratios: &[f64], chosen: &[usize]) -> Seen {
        let Rest { count, square, shares, .. } = &self.rest;
        let inverse = here.factor.inverse();
        let mut moved = DMatrix::zeros(self.z.len(), chosen.len());
        for (mut column, &k) in moved.column_iter_mut().zip(chosen) {
            column.gemv(ratios[k], &self.of_kernels[k], &here.solved, 0.0);
        }
        let of_rest =
            DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| ratios[k] * shares[k] / here.w));
        let traces = chosen.iter().map(|&k| ratios[k] * inverse.dot(&self.of_kernels[k]));
        let traces = DVector::from_iterator(chosen.len(), traces) + &of_rest * *count;
        let squares = moved.tr_mul(&here.solved) + &of_rest * (square / here.w);
        let of_rest = &of_rest * of_rest.transpose() * (square / here.w);
        let information = (moved.tr_mul(&here.factor.solve(&moved)) + of_rest) * 2.0;
        Seen { traces, squares, information }
    }
}

/// Adds to the lower triangle, of which a factor is formed: three thousand times for one fit.
fn add_lower(by: f64, matrix: &DMatrix<f64>, to: &mut DMatrix<f64>) {
    let n = to.nrows();
    for column in 0..n {
        let lower = column * (n + 1)..(column + 1) * n;
        let pairs = to.as_mut_slice()[lower.clone()].iter_mut().zip(&matrix.as_slice()[lower]);
        pairs.for_each(|(sum, value)| *sum += by * value);
    }
}

/// v̂ of every kernel.
pub(super) fn variances(mode: &Mode) -> Vec<f64> {
    mode.x()[1..].iter().map(|ln| (2.0 * (mode.x()[0] + ln)).exp()).collect()
}

/// T.
fn directions(precision: &DMatrix<Real>, kernels: &Kernels, variances: &[f64]) -> DMatrix<Real> {
    let rows = precision.nrows();
    let most = MOST_DIRECTIONS.min(rows / READINGS_PER_DIRECTION);
    let sums = Sums::new(kernels, variances);
    let mut moved = DMatrix::from_fn(rows, most, |i, j| sign(i * most + j));
    for _ in 0..POWERS {
        moved = sums.times(&(precision * moved));
        moved.column_iter_mut().for_each(|mut column| {
            let size = column.norm().max(Real::MIN_POSITIVE);
            column /= size;
        });
    }
    let t = precision * &moved;
    let gram = moved.tr_mul(&t).cast::<f64>();
    let eigen = ((&gram + gram.transpose()) * 0.5).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..most).filter(|&i| eigen.eigenvalues[i] > LEAST_SIZE * largest).collect();
    let to = |i: usize, j: usize| eigen.eigenvectors[(i, kept[j])] / eigen.eigenvalues[kept[j]].sqrt();
    t * DMatrix::from_fn(most, kept.len(), to).cast::<Real>()
}

/// Random signs, the same every time: bits of the numbers of Weyl, mixed.
fn sign(at: usize) -> Real {
    let mixed = (at as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    if (mixed >> 40) & 1 == 0 { 1.0 } else { -1.0 }
}

/// Σ_k (v̂_k/√d_k) K_k, frame by frame.
struct Sums<'a> {
    kernels: &'a Kernels,
    /// Over pairs of points, and over every point by itself.
    of_frames: Vec<(DMatrix<Real>, Real)>,
}

impl<'a> Sums<'a> {
    fn new(kernels: &'a Kernels, variances: &[f64]) -> Self {
        let points = kernels.points;
        let mut of_frames = vec![(DMatrix::zeros(points, points), 0.0); kernels.frames.len()];
        for (kernel, variance) in kernels.list.iter().zip(variances) {
            let (over_pairs, own) = &mut of_frames[kernel.frame];
            match &kernel.over {
                Over::Own => *own += *variance as Real / (points as Real).sqrt(),
                Over::Pairs(pairs) => {
                    let weight = *variance as Real * pairs.norm() / points as Real;
                    over_pairs.zip_apply(pairs, |sum, pair| *sum += weight * pair);
                }
            }
        }
        Self { kernels, of_frames }
    }

    fn times(&self, columns: &DMatrix<Real>) -> DMatrix<Real> {
        let mut product = DMatrix::zeros(columns.nrows(), columns.ncols());
        for (frame, (pairs, own)) in self.kernels.frames.iter().zip(&self.of_frames) {
            let folded = frame.folded_columns(columns);
            frame.add_unfolded(&(pairs * &folded + folded * *own), &mut product);
        }
        product
    }
}
