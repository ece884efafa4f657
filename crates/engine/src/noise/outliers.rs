//! Points far from the rest, set aside.
//!
//! A point is flagged when its residual is longer than 5 robust standard deviations (median length over the median of the
//! χ distribution). More than two flagged in a row are structure that the model lacks, not mishaps, and more than
//! 6 % flagged means that the model is wrong, not the points: then none is set aside. Hard deletion, iterated
//! by the caller.

use crate::Experiment;
use nalgebra::DVector;

const SIGMAS: f64 = 5.0;
const LONGEST_RUN: usize = 2;
const LARGEST_SHARE: f64 = 0.06;
/// Readings are never trusted below this, mm: ten times under the resolution of any probe.
const FINEST_MM: f64 = 1e-6;

/// True for points to use.
pub(crate) fn without_outliers(experiment: &Experiment, residual_mm: &DVector<f64>) -> Vec<bool> {
    let count = experiment.points.len();
    let mut length_in_sigma: Vec<f64> = Vec::with_capacity(count);
    for i in 0..count {
        let rows = experiment.rows_of(i);
        let median_of_chi = if rows.len() == 3 { 1.538 } else { 0.6745 };
        length_in_sigma.push(residual_mm.rows(rows.start, rows.len()).norm() / median_of_chi);
    }
    let sigma = median(&length_in_sigma).max(FINEST_MM);
    let chi: Vec<f64> = (0..count)
        .map(|i| {
            let rows = experiment.rows_of(i);
            residual_mm.rows(rows.start, rows.len()).norm() / sigma
        })
        .collect();
    let mut flagged: Vec<bool> = chi.iter().map(|chi| *chi > SIGMAS).collect();
    let mut start = 0;
    while start < count {
        let end = (start..count).find(|&i| !flagged[i]).unwrap_or(count);
        if end - start > LONGEST_RUN {
            flagged[start..end].fill(false);
        }
        start = end + 1;
    }
    let share = flagged.iter().filter(|f| **f).count() as f64 / count as f64;
    if share > LARGEST_SHARE {
        flagged.fill(false);
    }
    flagged.iter().map(|f| !f).collect()
}

pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    if sorted.is_empty() {
        return 0.0;
    }
    let middle = sorted.len() / 2;
    *sorted.select_nth_unstable_by(middle, f64::total_cmp).1
}
