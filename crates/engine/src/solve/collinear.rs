//! Columns that depend on each other: condition index η = s_1/s_n of the columns scaled to unit length, and whose variance the weak directions hold
//! [Belsley 1980].

use crate::evidence::off;
use crate::solve::linear::Reduced;
use nalgebra::DMatrix;

/// η beyond which dependencies are moderate to strong [Belsley 1980 §3.2].
pub(crate) const CONDITION_INDEX: f64 = 30.0;
/// Share of the variance of a coefficient that says it is involved [Belsley 1980 §3.2].
const VARIANCE_SHARE: f64 = 0.5;
/// Relative singular value of a direction that the columns of settings do not have.
const NO_DIRECTION: f64 = 1e-8;

/// η of columns; of those that are zero it says nothing.
pub(crate) fn condition_index(columns: &DMatrix<f64>) -> f64 {
    let kept: Vec<usize> = (0..columns.ncols()).filter(|&k| columns.column(k).norm() > 0.0).collect();
    let columns = scaled(columns.select_columns(&kept));
    let eigen = columns.tr_mul(&columns).symmetric_eigenvalues();
    if eigen.is_empty() { 1.0 } else { (eigen.max() / eigen.min().max(f64::MIN_POSITIVE)).sqrt() }
}

/// Largest condition index and the columns that it concerns; what all settings together imitate is projected out.
pub(crate) fn collinear(mut columns: DMatrix<f64>, settings: &DMatrix<f64>) -> Option<(f64, Vec<usize>)> {
    if settings.ncols() > 0 {
        let basis = settings * Reduced::from_design(settings).orthonormal(NO_DIRECTION);
        columns = off(&columns, &basis);
    }
    let columns = scaled(columns);
    let eigen = columns.tr_mul(&columns).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let weak = |k: usize| largest > CONDITION_INDEX.powi(2) * eigen.eigenvalues[k];
    let share = |j: usize, wanted: &dyn Fn(usize) -> bool| -> f64 {
        let part =
            |k: usize| eigen.eigenvectors[(j, k)].powi(2) / eigen.eigenvalues[k].max(f64::MIN_POSITIVE);
        (0..eigen.eigenvalues.len()).filter(|&k| wanted(k)).map(part).sum()
    };
    let involved: Vec<usize> =
        (0..columns.ncols()).filter(|&j| share(j, &weak) > VARIANCE_SHARE * share(j, &|_| true)).collect();
    (involved.len() > 1).then(|| ((largest / eigen.eigenvalues.min()).sqrt(), involved))
}

/// To unit length; nothing stays nothing.
fn scaled(mut columns: DMatrix<f64>) -> DMatrix<f64> {
    for mut column in columns.column_iter_mut() {
        let norm = column.norm();
        column /= if norm > 0.0 { norm } else { 1.0 };
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two settings that resemble each other: one after the other they would leave e₃ ± ½(e₁ − e₂).
    #[test]
    fn what_settings_imitate_together_is_projected_out() {
        let matrix = |columns: &[[f64; 4]; 2]| {
            DMatrix::from_columns(&columns.map(|column| nalgebra::DVector::from_row_slice(&column)))
        };
        let settings = matrix(&[[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]]);
        let (index, involved) =
            collinear(matrix(&[[0.0, 1.0, 1.0, 0.0], [0.0, -1.0, 1.0, 1e-3]]), &settings).expect("collinear");
        assert!(index > CONDITION_INDEX && involved == [0, 1], "{index} {involved:?}");
    }
}
