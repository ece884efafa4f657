//! Null-space pairs: data whose least-squares solution is known beforehand.
//!
//! b = A b₀ + r, Aᵀ r = 0. For the solver, columns and b₀ are cut to few bits, so that A b₀ is formed without rounding; r is
//! orthogonalised until nothing is left. For the whole program A b₀ is the exact prediction.

use super::document::digits;
use super::experiment::{columns, exact_readings, experiment, model, options, set_readings, truth};
use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trunnion_engine::identify;
use trunnion_engine::solve::linear::least_squares;

/// Digits on one pair.
pub struct Row {
    pub pair: &'static str,
    pub rows: usize,
    pub columns: usize,
    pub rms: &'static str,
    pub digits: f64,
}

pub fn rows() -> Vec<Row> {
    vec![
        of_solver("the solver, residual of the size of noise", "0.3 µm", 0.3e-3),
        of_solver("the solver, residual 1000 times larger", "0.3 mm", 0.3),
        of_identify("`identify`, columns held in memory", 1),
        of_identify("`identify`, columns streamed into the Gram matrix", 200),
    ]
}

fn of_solver(pair: &'static str, rms: &'static str, rms_mm: f64) -> Row {
    let experiment = experiment(1);
    let truth = truth(&experiment);
    let a = columns(&experiment, &model()).select_columns(&truth.seen).map(|x| cut(x, 26));
    let b_0 = DVector::from_iterator(a.ncols(), truth.seen.iter().map(|&j| cut(truth.solution[j], 20)));
    let r = orthogonal_to(&a, rms_mm);
    let found = least_squares(&a, &(&a * &b_0 + r), 1e-12).x;
    Row { pair, rows: a.nrows(), columns: a.ncols(), rms, digits: agreement(&found, &b_0, &truth.reach) }
}

/// The whole program on the exact readings of the truth plus the residual.
fn of_identify(pair: &'static str, rounds: usize) -> Row {
    let mut experiment = experiment(rounds);
    let truth = truth(&experiment);
    let a = columns(&experiment, &model()).select_columns(&truth.seen);
    let readings = exact_readings(&experiment, &truth.solution) + orthogonal_to(&a, 0.3e-3);
    set_readings(&mut experiment, readings.as_slice());
    let fit = identify(&experiment, &model(), &options()).expect("a fit");
    let of = |x: &DVector<f64>| DVector::from_iterator(a.ncols(), truth.seen.iter().map(|&j| x[j]));
    let digits = agreement(&of(&fit.solution), &of(&truth.solution), &truth.reach);
    Row { pair, rows: a.nrows(), columns: a.ncols(), rms: "0.3 µm", digits }
}

/// Digits in units of what the largest parameter moves.
fn agreement(found: &DVector<f64>, b_0: &DVector<f64>, reach: &DVector<f64>) -> f64 {
    let off = (found - b_0).component_mul(reach).amax();
    digits(1.0 + off / b_0.component_mul(reach).amax(), 1.0)
}

/// A normal vector of the given rms made orthogonal to the columns.
fn orthogonal_to(a: &DMatrix<f64>, rms: f64) -> DVector<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let mut r = DVector::from_fn(a.nrows(), |_, _| -> f64 { StandardNormal.sample(&mut rng) });
    r *= rms * (r.len() as f64).sqrt() / r.norm();
    let norms = DVector::from_iterator(a.ncols(), a.column_iter().map(|c| c.norm()));
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / norms[j]);
    let gram = (scaled.transpose() * &scaled).cholesky().expect("determined columns");
    for _ in 0..4 {
        let left = DVector::from_iterator(
            a.ncols(),
            (0..a.ncols()).map(|j| exact_dot(&scaled.column(j).into_owned(), &r)),
        );
        r -= &scaled * gram.solve(&left);
    }
    r
}

/// Dot product in doubled precision (two-product, two-sum).
fn exact_dot(a: &DVector<f64>, b: &DVector<f64>) -> f64 {
    let (mut high, mut low) = (0.0f64, 0.0f64);
    for (&x, &y) in a.iter().zip(b) {
        let product = x * y;
        low += x.mul_add(y, -product);
        let sum = high + product;
        let back = sum - high;
        low += (high - (sum - back)) + (product - back);
        high = sum;
    }
    high + low
}

/// `x` with its leading `bits` bits.
fn cut(x: f64, bits: i32) -> f64 {
    if x == 0.0 {
        return 0.0;
    }
    let unit = f64::from(bits - 1 - x.abs().log2().floor() as i32).exp2();
    (x * unit).round() / unit
}
