//! Minimum-zone circles: the two concentric circles, nearest to each other, between which all points lie [ISO 1101; ISO 12181-1, MZCI].
//!
//! Small deviations ρ(φ) from a circle, centre (a, b): half of the zone is min over c, a, b of max |ρ − c − a cos φ − b sin φ|. The functions 1, cos, sin
//! make a Chebyshev system on the circle, so the minimum has four points whose errors alternate in sign; they are found by exchange
//! (Remez 1934): solve for four, bring in the worst point, let go of the one whose neighbour it replaces in the alternation.
//! Limits: first order in deviation over radius.

use super::GeometryError;
use nalgebra::{Matrix4, Vector4};

/// Exchanges after which the worst point no longer changes; each raises the zone, and there are finitely many fours.
const MOST_EXCHANGES: usize = 1000;
/// Relative rounding of the zone.
const ROUNDING: f64 = 1e-12;

/// Width of the zone of deviations at angles (rad, deviation).
///
/// # Errors
/// Fewer than four angles apart, a number that is none.
pub fn minimum_zone(points: &[(f64, f64)]) -> Result<f64, GeometryError> {
    if let Some(point) = points.iter().position(|(angle, off)| !angle.is_finite() || !off.is_finite()) {
        return Err(GeometryError::NotFinite { shape: "minimum zone", point });
    }
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let undetermined =
        || GeometryError::Undetermined { shape: "minimum zone", why: "they lie at fewer than four angles" };
    let mut four = spread(&sorted).ok_or_else(undetermined)?;
    for _ in 0..MOST_EXCHANGES {
        let of_four = levelled(&sorted, four).ok_or_else(undetermined)?;
        let half = of_four.w.abs();
        let error = |k: usize| sorted[k].1 - fitted(&of_four, sorted[k].0);
        let worst = (0..sorted.len()).max_by(|&i, &j| error(i).abs().total_cmp(&error(j).abs()));
        let Some(worst) = worst.filter(|&k| error(k).abs() > half * (1.0 + ROUNDING)) else {
            return Ok(2.0 * half);
        };
        four = exchanged(four, worst, |k| error(k) > 0.0);
    }
    Err(undetermined())
}

fn fitted(of: &Vector4<f64>, angle: f64) -> f64 {
    of.x + of.y * angle.cos() + of.z * angle.sin()
}

/// Four points whose angles are a quarter of a turn apart, as far as there are.
fn spread(sorted: &[(f64, f64)]) -> Option<[usize; 4]> {
    let mut distinct: Vec<usize> = Vec::new();
    for k in 0..sorted.len() {
        if distinct.last().is_none_or(|&last| sorted[k].0 - sorted[last].0 > ROUNDING) {
            distinct.push(k);
        }
    }
    let count = distinct.len();
    (count >= 4).then(|| [0, 1, 2, 3].map(|q| distinct[q * count / 4]))
}

/// c, a, b and the error h, alternating in sign: ρ_k = c + a cos + b sin + (−1)^k h.
fn levelled(sorted: &[(f64, f64)], four: [usize; 4]) -> Option<Vector4<f64>> {
    let rows = Matrix4::from_fn(|i, j| {
        let angle = sorted[four[i]].0;
        [1.0, angle.cos(), angle.sin(), if i % 2 == 0 { 1.0 } else { -1.0 }][j]
    });
    rows.lu().solve(&Vector4::from_fn(|i, _| sorted[four[i]].1))
}

/// The worst point takes the place of the neighbour in angle whose error has its sign.
fn exchanged(mut four: [usize; 4], worst: usize, positive: impl Fn(usize) -> bool) -> [usize; 4] {
    let after = four.iter().position(|&k| k > worst).unwrap_or(0);
    let before = (after + 3) % 4;
    let place = if positive(four[before]) == positive(worst) { before } else { after };
    four[place] = worst;
    four.sort_unstable();
    four
}
