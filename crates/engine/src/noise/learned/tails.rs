//! Weights of points where more of them lie outside than a normal law allows: Student's t, as learned from the white parts.
//!
//! The white part of a point is e = s² W P y, of channels that scatter unlike s² √(W (W + W_c)) P y: as large as that of the others. With u
//! the mean square of its components over its median, the weight of the white variance is (ν + k u)/(ν + k).

use super::kernels::Kernels;
use super::mode::Mode;
use super::sigma::NOTHING;
use nalgebra::DVector;
use std::ops::Range;
use trunnion_core::statistics::upper_median;

/// Of χ²_k/k: median and the point beyond which 1 % of a normal law lies, for one and for three components.
const MEDIAN: [f64; 2] = [0.455, 0.789];
const RARE: [f64; 2] = [6.63, 3.78];
/// Shares beyond the rare point at which tails are heavy, and very heavy.
const HEAVY: f64 = 0.02;
const VERY_HEAVY: f64 = 0.035;
/// Single points beyond this times the rare point count as wild, those beyond the second multiple as worth nothing.
const WILD: f64 = 3.2;
const WORTHLESS: f64 = 8.0;
/// Parts of two visits of a pose that differ by less than this share of theirs are one: by chance two of three components do so once in 60.
const SAME_WITHIN: f64 = 0.5;

/// Multiples of the white variance of every row; `None` where the tails are those of a normal law.
pub(crate) fn weights(
    mode: &Mode,
    kernels: &Kernels,
    poses: &[usize],
    now: &DVector<f64>,
    used: &[bool],
) -> Option<DVector<f64>> {
    let of_channels = kernels.white_of_rows(&mode.rho_squared());
    let scale = (now.component_mul(&(now + of_channels))).map(f64::sqrt) * mode.s().powi(2);
    let part = |row: usize| f64::from(mode.here.py[row]) * scale[row];
    let mean_square = |rows: &Range<usize>| {
        rows.clone().map(|row| part(row).powi(2)).sum::<f64>() / rows.len().max(1) as f64
    };
    let rows_of_point = &kernels.rows_of_point;
    let squares: Vec<f64> = rows_of_point.iter().map(mean_square).collect();
    let sort = |rows: &Range<usize>| usize::from(rows.len() > 1);
    let of_sort = |sort_wanted: usize| {
        let chosen = (0..squares.len()).filter(|&i| used[i] && sort(&rows_of_point[i]) == sort_wanted);
        upper_median(&chosen.map(|i| squares[i]).collect::<Vec<_>>()).unwrap_or(0.0).max(1e-12)
    };
    let medians = [of_sort(0), of_sort(1)];
    let mut relative: Vec<(f64, f64)> = (0..squares.len())
        .map(|i| {
            let k = sort(&rows_of_point[i]);
            (MEDIAN[k] * squares[i] / medians[k], RARE[k])
        })
        .collect();
    // What comes back at its pose is no tail but the machine.
    let parts = |i: usize| DVector::from_iterator(rows_of_point[i].len(), rows_of_point[i].clone().map(part));
    let far: Vec<usize> = (0..squares.len()).filter(|&i| used[i] && relative[i].0 > relative[i].1).collect();
    let comes_back = |i: usize| {
        let visits = far.iter().filter(|&&j| j != i && poses[j] == poses[i]);
        visits.map(|&j| parts(j)).any(|other| (parts(i) - &other).norm() < SAME_WITHIN * other.norm())
    };
    for &i in &far {
        if comes_back(i) {
            relative[i].0 = MEDIAN[sort(&rows_of_point[i])];
        }
    }
    let taking_part: Vec<&(f64, f64)> =
        relative.iter().zip(used).filter(|(_, used)| **used).map(|(r, _)| r).collect();
    let beyond = |times: f64| {
        taking_part.iter().filter(|(u, rare)| *u > times * rare).count() as f64
            / taking_part.len().max(1) as f64
    };
    let far = beyond(1.0);
    if far < HEAVY && beyond(WILD) == 0.0 {
        return None;
    }
    let freedom = if far > VERY_HEAVY { 4.0 } else { 8.0 };
    let least = if far > HEAVY { 0.6 } else { 1.0 };
    let mut weights = now.clone();
    for (i, rows) in rows_of_point.iter().enumerate() {
        let (u, rare) = relative[i];
        let components = rows.len() as f64;
        let weight = (freedom + components * u) / (freedom + components);
        let wild = !used[i] || u > WORTHLESS * rare;
        weights.rows_mut(rows.start, rows.len()).fill(if wild { NOTHING } else { weight.max(least) });
    }
    Some(weights)
}
