//! Plain least squares of the model and chosen columns: what a fit leaves, which points are mishaps, what left-out parts say.

use crate::diagnosis::problem::Problem;
use crate::evidence::stacked;
use nalgebra::{DMatrix, DVector};

/// A point farther out than this many robust standard deviations is set aside.
const OUTLIER_SIGMA: f64 = 5.0;
/// Median of the length of a standard normal vector with 1 and with 3 components.
const MEDIAN_LENGTH: [f64; 2] = [0.6745, 1.5382];
/// Longer runs of far points are structure, not outliers.
const LONGEST_OUTLIER_RUN: usize = 2;
/// A larger share of far points is a heavy tail, not outliers.
const MOST_OUTLIERS: f64 = 0.06;

/// What a fit of base and chosen columns leaves.
pub struct Fit {
    /// Readings with the outliers replaced by their prediction.
    pub readings: DVector<f64>,
    /// True for each point set aside.
    pub outlier: Vec<bool>,
    /// Root mean square of the residual without outliers, mm.
    pub rms_mm: f64,
}

impl Problem<'_> {
    /// Ordinary least squares of base and `chosen` (column × row) with outliers set aside.
    pub fn fit(&self, chosen: &DMatrix<f64>) -> Fit {
        let design = stacked(&self.base, chosen);
        let points = self.experiment.points.len();
        let mut outlier = vec![false; points];
        let mut residual = self.readings.clone();
        for _ in 0..6 {
            residual = &self.readings - solve(&design, &self.readings, &self.weights(&outlier));
            let far = self.far_points(&residual);
            if far == outlier {
                break;
            }
            outlier = far;
        }
        let mut readings = self.readings.clone();
        let (mut sum, mut count) = (0.0, 0);
        for point in 0..points {
            for row in self.experiment.rows_of(point) {
                if outlier[point] {
                    readings[row] -= residual[row];
                } else {
                    sum += (residual[row] / self.root[row]).powi(2);
                    count += 1;
                }
            }
        }
        Fit { readings, outlier, rms_mm: (sum / f64::from(count.max(1))).sqrt() }
    }

    /// Root mean square of predictions of parts of the data from the rest, mm: whole passes, or stations of the slow axis
    /// where a setup was measured in one pass only.
    pub fn holdout_rms_mm(&self, chosen: &DMatrix<f64>, outlier: &[bool]) -> f64 {
        let design = stacked(&self.base, chosen);
        let fold_of_point = self.folds();
        let folds = fold_of_point.iter().max().map_or(0, |last| last + 1);
        let full = &self.readings - solve(&design, &self.readings, &self.weights(outlier));
        let (mut sum, mut count) = (0.0, 0);
        for fold in 0..folds {
            let out: Vec<bool> = (0..outlier.len()).map(|i| outlier[i] || fold_of_point[i] == fold).collect();
            // How the fit changes without the fold; what only the fold sees, such as the setting of its own ball, stays.
            let residual = &full - solve(&design, &full, &self.weights(&out));
            for point in (0..outlier.len()).filter(|&i| fold_of_point[i] == fold && !outlier[i]) {
                for row in self.experiment.rows_of(point) {
                    sum += (residual[row] / self.root[row]).powi(2);
                    count += 1;
                }
            }
        }
        (sum / f64::from(count.max(1))).sqrt()
    }

    fn folds(&self) -> Vec<usize> {
        let axis = self.order.slow.or(self.order.fast);
        let direction = |i: usize| axis.map_or(0, |l| self.experiment.points[i].state.direction[l] as i64);
        let mut passes: Vec<(usize, i64)> = Vec::new();
        let of_point: Vec<usize> = (0..self.experiment.points.len())
            .map(|i| {
                let pass = (self.experiment.points[i].state.setup, direction(i));
                passes.iter().position(|p| *p == pass).unwrap_or_else(|| {
                    passes.push(pass);
                    passes.len() - 1
                })
            })
            .collect();
        let setups = self.experiment.setups.len();
        let both_ways = (0..setups).all(|s| passes.iter().filter(|p| p.0 == s).count() != 1);
        if both_ways { of_point } else { self.order.stations().into_iter().map(|s| s % 4).collect() }
    }

    fn weights(&self, outlier: &[bool]) -> Vec<bool> {
        let mut used = vec![true; self.experiment.rows()];
        for (point, _) in outlier.iter().enumerate().filter(|(_, out)| **out) {
            for row in self.experiment.rows_of(point) {
                used[row] = false;
            }
        }
        used
    }

    fn far_points(&self, residual: &DVector<f64>) -> Vec<bool> {
        let points = self.experiment.points.len();
        let relative: Vec<f64> = (0..points)
            .map(|i| {
                let rows = self.experiment.rows_of(i);
                residual.rows(rows.start, rows.len()).norm() / MEDIAN_LENGTH[usize::from(rows.len() == 3)]
            })
            .collect();
        let mut sorted = relative.clone();
        sorted.sort_by(f64::total_cmp);
        let sigma = sorted[points / 2];
        let mut far: Vec<bool> = relative.iter().map(|r| *r > OUTLIER_SIGMA * sigma).collect();
        let sequence: Vec<usize> = self.order.points().collect();
        let mut k = 0;
        while k < points {
            let length = sequence[k..].iter().take_while(|&&i| far[i]).count();
            if length > LONGEST_OUTLIER_RUN {
                for &i in &sequence[k..k + length] {
                    far[i] = false;
                }
            }
            k += length.max(1);
        }
        let share = far.iter().filter(|f| **f).count() as f64 / points as f64;
        if share > MOST_OUTLIERS { vec![false; points] } else { far }
    }
}

/// Prediction of least squares on the rows used; directions the design cannot see stay zero.
pub fn solve(design: &DMatrix<f64>, readings: &DVector<f64>, used: &[bool]) -> DVector<f64> {
    let mut masked = design.clone();
    for (row, _) in used.iter().enumerate().filter(|(_, used)| !**used) {
        masked.column_mut(row).fill(0.0);
    }
    let scale: Vec<f64> = masked.row_iter().map(|c| c.norm()).collect();
    for (j, mut column) in masked.row_iter_mut().enumerate() {
        column /= scale[j].max(1e-300);
    }
    let gram = &masked * masked.transpose();
    let right = &masked * readings;
    let eigen = gram.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut along = eigen.eigenvectors.transpose() * right;
    for (j, value) in along.iter_mut().enumerate() {
        let eigenvalue = eigen.eigenvalues[j];
        *value = if eigenvalue > 1e-12 * largest { *value / eigenvalue } else { 0.0 };
    }
    let mut values = &eigen.eigenvectors * along;
    for (j, value) in values.iter_mut().enumerate() {
        *value /= scale[j].max(1e-300);
    }
    design.tr_mul(&values)
}
