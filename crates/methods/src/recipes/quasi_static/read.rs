//! The readings of one sweep next to what was fitted to them.

use nalgebra::{DMatrix, DVector};
use trunnion_effects::Model;
use trunnion_engine::solve::linear::least_squares;
use trunnion_engine::{Experiment, Identification, Problem};

/// Relative singular value below which a direction is not seen: what a fit leaves of a determined parameter is far above.
const TOLERANCE: f64 = 1e-9;

/// The readings of one sweep; rows as in its points.
pub(super) struct Read {
    /// Number of the run, and of each point among the good ones of the run.
    pub of_run: usize,
    pub numbers: Vec<usize>,
    /// Points that took part in the fit.
    pub used: Vec<bool>,
    /// Columns of the errors that are split, mm per inside unit; rows × errors.
    pub of_errors: DMatrix<f64>,
    /// Of what else the fit determines.
    pub of_others: DMatrix<f64>,
    /// What every reading counts in each error: rows × errors.
    pub shares: DMatrix<f64>,
    /// What the errors make of the readings, with what the fit leaves, mm.
    pub deviation_mm: DVector<f64>,
}

impl Read {
    /// `place`: number of the run and of each point. `None` where the fit took means of the readings.
    pub fn of(
        experiment: &Experiment,
        fit: &Identification,
        names: &[&str],
        values: &[f64],
        (of_run, numbers): (usize, &[usize]),
    ) -> Option<Self> {
        if experiment.points.len() != numbers.len() {
            return None;
        }
        let model = Model::base(&experiment.machine().name);
        let columns = Problem::of_fit(experiment, &model, fit).columns(experiment).ok()?;
        let column_of = |name: &str| fit.parameters.iter().position(|found| found.name == name);
        let of_errors: Vec<usize> = names.iter().filter_map(|name| column_of(name)).collect();
        let is_other = |k: &usize| fit.parameters[*k].u.is_some() && !of_errors.contains(k);
        let of_others: Vec<usize> = (0..fit.parameters.len()).filter(is_other).collect();
        let mut both = columns.select_columns(&[&of_errors[..], &of_others].concat());
        experiment.unused_rows(&fit.used).for_each(|row| both.row_mut(row).fill(0.0));
        let cofactor = least_squares(&both, &fit.residual_mm, TOLERANCE).cofactor;
        let of_errors = columns.select_columns(&of_errors);
        Some(Self {
            of_run,
            numbers: numbers.to_vec(),
            used: fit.used.clone(),
            shares: (both * cofactor).columns(0, names.len()).into_owned(),
            deviation_mm: &of_errors * DVector::from_column_slice(values) + &fit.residual_mm,
            of_errors,
            of_others: columns.select_columns(&of_others),
        })
    }
}
