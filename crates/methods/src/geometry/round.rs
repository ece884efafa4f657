//! The common kernel of circle (N = 2) and sphere (N = 3).
//!
//! min Σ (|p_i − c| − r)².  Start: `2 c·p + (r² − c²) = p²` (Coope 1993), linear.  Then Gauss–Newton with step halving:
//! `∂d_i/∂c = −(p_i − c)/|p_i − c|`, `∂d_i/∂r = −1`.

use super::GeometryError;
use super::scatter::Scatter;
use nalgebra::{DMatrix, DVector, SVector};

const MOST_STEPS: usize = 200;
const MOST_HALVINGS: i32 = 40;
/// A step below this share of the radius, and no longer falling, has arrived.
const ARRIVED: f64 = 1e-10;
/// Relative rounding of a sum of squares.
const ROUNDING: f64 = 1e-13;
/// Centre farther away than this many times the spread of the points: a line or plane fits alike.
const FARTHEST: f64 = 1e7;

/// Centre and radius.
pub(super) fn round<const N: usize>(
    shape: &'static str,
    points: &[SVector<f64, N>],
) -> Result<(SVector<f64, N>, f64), GeometryError> {
    let scatter = Scatter::of(shape, N + 1, points)?;
    let flat = GeometryError::Undetermined {
        shape,
        why: if N == 2 { "they lie on a line" } else { "they lie in a plane" },
    };
    if !scatter.spans(N) {
        return Err(flat);
    }
    // About the centroid and in units of the spread, so that squares lose no digits.
    let unit = scatter.spread[0] / (points.len() as f64).sqrt();
    let scaled: Vec<SVector<f64, N>> = points.iter().map(|p| (p - scatter.centroid) / unit).collect();
    let mut best = algebraic(&scaled).ok_or_else(|| flat.clone())?;
    let mut squares = sum_of_squares(&scaled, &best);
    let mut last_step = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let step = gauss_newton_step(&scaled, &best).ok_or_else(|| flat.clone())?;
        let taken = (0..MOST_HALVINGS).find_map(|halvings: i32| {
            let tried = add(&best, &(&step * 0.5f64.powi(halvings)));
            let of_tried = sum_of_squares(&scaled, &tried);
            (of_tried <= squares * (1.0 + ROUNDING)).then_some((tried, of_tried))
        });
        // Near the minimum the squares say nothing any more; the steps fall until they are rounding.
        let arrived = step.amax() <= ARRIVED * best.1 && step.amax() >= last_step;
        let Some((better, of_better)) = taken.filter(|_| !arrived) else { break };
        (best, squares, last_step) = (better, of_better, step.amax());
    }
    if best.0.norm() > FARTHEST {
        return Err(flat);
    }
    Ok((scatter.centroid + best.0 * unit, best.1 * unit))
}

fn algebraic<const N: usize>(points: &[SVector<f64, N>]) -> Option<(SVector<f64, N>, f64)> {
    let design = DMatrix::from_fn(points.len(), N + 1, |i, j| if j < N { 2.0 * points[i][j] } else { 1.0 });
    let squares = DVector::from_fn(points.len(), |i, _| points[i].norm_squared());
    let found = solve(design, &squares)?;
    let centre = SVector::<f64, N>::from_fn(|j, _| found[j]);
    let r = (found[N] + centre.norm_squared()).max(0.0).sqrt();
    Some((centre, r))
}

fn gauss_newton_step<const N: usize>(
    points: &[SVector<f64, N>],
    (centre, r): &(SVector<f64, N>, f64),
) -> Option<DVector<f64>> {
    let arm = |i: usize| points[i] - centre;
    let slope = DMatrix::from_fn(points.len(), N + 1, |i, j| {
        if j == N { 1.0 } else { arm(i)[j] / arm(i).norm().max(f64::MIN_POSITIVE) }
    });
    solve(slope, &DVector::from_fn(points.len(), |i, _| arm(i).norm() - r))
}

fn solve(design: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let qr = design.qr();
    let mut projected = right.clone();
    qr.q_tr_mul(&mut projected);
    let r = qr.r();
    r.solve_upper_triangular(&projected.rows(0, r.ncols()).into_owned())
}

fn add<const N: usize>(at: &(SVector<f64, N>, f64), step: &DVector<f64>) -> (SVector<f64, N>, f64) {
    (SVector::from_fn(|j, _| at.0[j] + step[j]), at.1 + step[N])
}

fn sum_of_squares<const N: usize>(points: &[SVector<f64, N>], at: &(SVector<f64, N>, f64)) -> f64 {
    points.iter().map(|p| ((p - at.0).norm() - at.1).powi(2)).sum()
}
