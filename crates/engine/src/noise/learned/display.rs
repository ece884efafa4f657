//! The step of a display that is coarser than the noise.
//!
//! Such a display errs alike at like readings, so its error is a pattern, not noise: cos and sin of 2π reading/step in two harmonics
//! for every component are columns that are projected out. With a step of 0.87 µm over 0.05 µm of noise they remove four fifths of it.

use crate::Experiment;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Harmonics of the saw.
const HARMONICS: usize = 2;
/// Readings are compared to this, mm: a hundredth of a micrometre is no step that matters.
const FINEST_MM: f64 = 1e-8;
/// Share of differences that must be whole multiples, and how whole.
const ALL: f64 = 0.95;
const WHOLE: f64 = 0.05;

/// Smallest difference between readings where all are its multiples, mm.
pub(crate) fn step_mm(readings_mm: &DVector<f64>) -> Option<f64> {
    let mut values: Vec<f64> = readings_mm.iter().copied().collect();
    values.sort_by(f64::total_cmp);
    let gaps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > FINEST_MM).collect();
    let step = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    // As many values as readings show no step.
    let repeats = gaps.len() + 1 < values.len();
    let whole = gaps.iter().filter(|gap| ((*gap / step) - (*gap / step).round()).abs() < WHOLE).count();
    (repeats && step.is_finite() && whole as f64 > ALL * gaps.len() as f64).then_some(step)
}

/// Columns of the saw at the fitted readings, rows × columns.
pub(crate) fn saw(experiment: &Experiment, fitted_mm: &DVector<f64>, step_mm: f64) -> DMatrix<f64> {
    let most = (0..experiment.points.len()).map(|i| experiment.rows_of(i).len()).max().unwrap_or(0);
    let mut columns = DMatrix::zeros(experiment.rows(), most * HARMONICS * 2);
    for i in 0..experiment.points.len() {
        for (k, row) in experiment.rows_of(i).enumerate() {
            for harmonic in 0..HARMONICS {
                let (sin, cos) = (TAU * (harmonic + 1) as f64 * fitted_mm[row] / step_mm).sin_cos();
                columns[(row, (k * HARMONICS + harmonic) * 2)] = cos;
                columns[(row, (k * HARMONICS + harmonic) * 2 + 1)] = sin;
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_display_is_noticed_and_a_fine_one_is_not() {
        let shown = DVector::from_fn(200, |i, _| ((i as f64 * 1.37).sin() * 7.0 / 0.87).round() * 0.87e-3);
        assert!((step_mm(&shown).unwrap() - 0.87e-3).abs() < 1e-9);
        let fine = DVector::from_fn(200, |i, _| (i as f64 * 1.37).sin() * 7e-3);
        assert_eq!(step_mm(&fine), None);
    }
}
