//! What the base model, with every location error and setting free, leaves of readings.

use crate::Experiment;
use crate::evidence::{joined, off, orthonormal};
use crate::solve::linear::Reduced;
use nalgebra::{DMatrix, DVector};
use std::borrow::Borrow;
use trunnion_effects::{Instance, Model, Role, Subject};

/// Relative singular value of a direction that the columns do not see.
const UNSEEN: f64 = 1e-6;

/// A mistake, and what the model leaves with it undone, mm rms.
pub(super) type Tried = (String, f64);

/// Columns of the base model; none where the machine of the experiment has no such model.
pub(super) fn columns(experiment: &Experiment) -> Option<DMatrix<f64>> {
    let machine = experiment.machine();
    let model = Model::base(&machine.name);
    let mut columns = DMatrix::zeros(experiment.rows(), 0);
    for entry in &model.effects {
        let instance = Instance::from_model_effect(entry, machine).ok()?;
        columns = joined(&columns, &experiment.columns(&instance, &[]));
    }
    Some(columns)
}

/// Directions that the base model can explain, fitted to some of the rows.
pub(super) struct Fitted {
    /// On every row; orthonormal on those of the fit.
    directions: DMatrix<f64>,
    /// The same, zero on the rows that are left out.
    basis: DMatrix<f64>,
    /// Effects of one axis of which one may be in the model too: what the directions do not explain of their columns, orthonormal.
    effects: Vec<DMatrix<f64>>,
}

impl Fitted {
    pub fn new(experiment: &Experiment) -> Option<Self> {
        Some(Self::on(&columns(experiment)?, |_| true))
    }

    /// Fitted to the rows that are `used`.
    pub fn on(columns: &DMatrix<f64>, used: impl Fn(usize) -> bool) -> Self {
        let mut of_fit = columns.clone();
        for row in (0..columns.nrows()).filter(|row| !used(*row)) {
            of_fit.row_mut(row).fill(0.0);
        }
        let seen = Reduced::from_design(&of_fit).orthonormal(UNSEEN);
        Self { directions: columns * &seen, basis: of_fit * seen, effects: Vec::new() }
    }

    /// With whichever effect of one axis leaves the least, each time that it is asked what is left. Of a fit to every row.
    pub fn with_an_effect(&self, experiment: &Experiment) -> Self {
        let Self { directions, basis, .. } = self;
        let effects =
            effects_of_an_axis(experiment, |_| true).map(|columns| orthonormal(&off(&columns, basis)));
        Self { directions: directions.clone(), basis: basis.clone(), effects: effects.collect() }
    }

    /// What it leaves of readings, mm; of rows that were left out, how far they are from what the others say of them.
    pub fn left_mm(&self, readings_mm: &DVector<f64>) -> DVector<f64> {
        readings_mm - &self.directions * self.basis.tr_mul(readings_mm)
    }

    /// Readings of which some rows are lost, each of these as the fit to all others expects it: with M = 1 − BBᵀ, M_ll·y_l = −M_lu·y_u. Of a fit to every
    /// row.
    pub fn filled(&self, readings_mm: &DVector<f64>, lost: &[usize]) -> DVector<f64> {
        let mut filled = readings_mm.clone();
        let basis = self.basis.select_rows(lost);
        let own = DMatrix::identity(lost.len(), lost.len()) - &basis * basis.transpose();
        // A row that the others say nothing of stays as it is.
        if let Some(off_mm) = own.lu().solve(&self.left_mm(readings_mm).select_rows(lost)) {
            lost.iter().zip(off_mm.iter()).for_each(|(&row, mm)| filled[row] -= mm);
        }
        filled
    }

    /// What the model can explain along which the squares of readings are largest: the first eigenvector of Bᵀ·diag(y²)·B, on every row.
    pub fn strongest(&self, readings_mm: &DVector<f64>) -> Option<DVector<f64>> {
        let mut weighted = self.basis.clone();
        weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(readings_mm));
        let squares = (weighted.tr_mul(&weighted)).symmetric_eigen();
        (!squares.eigenvalues.is_empty())
            .then(|| &self.directions * squares.eigenvectors.column(squares.eigenvalues.imax()))
    }

    /// Rms of what it leaves of readings that are `before` up to a row and `after` from that row on, mm: for each of `rows`, ascending.
    /// Σr² = |y|² − |Bᵀy|², both summed row by row. Of a fit to every row.
    pub fn left_of_switch_mm(&self, before: &DVector<f64>, after: &DVector<f64>, rows: &[usize]) -> Vec<f64> {
        let (mut square, mut along) = (after.norm_squared(), self.basis.tr_mul(after));
        let mut next = 0;
        let of_row = |&switch: &usize| {
            for row in next..switch {
                square += before[row].powi(2) - after[row].powi(2);
                along += self.basis.row(row).transpose() * (before[row] - after[row]);
            }
            next = switch;
            ((square - along.norm_squared()).max(0.0) / before.len().max(1) as f64).sqrt()
        };
        rows.iter().map(of_row).collect()
    }

    /// Rms of what it leaves of readings that are `inside` from one row to before another, and `outside` elsewhere, mm, and between which two of
    /// `rows`, ascending, that is the least. From one row to the next Σr² = |y|² − |Bᵀy|² changes by sums of its own. Of a fit to every row.
    pub fn least_of_windows_mm(
        &self,
        outside: &DVector<f64>,
        inside: &DVector<f64>,
        rows: &[usize],
    ) -> Option<([usize; 2], f64)> {
        let (along_outside, whole) = (self.basis.tr_mul(outside), outside.norm_squared());
        // A column for each of `rows`: what the readings before it add to Bᵀy, and to |y|².
        let mut along = DMatrix::<f64>::zeros(along_outside.len(), rows.len());
        let mut square = DVector::<f64>::zeros(rows.len());
        let mut next = 0;
        for (end, &row_of_end) in rows.iter().enumerate() {
            if end > 0 {
                square[end] = square[end - 1];
                let before = along.column(end - 1).clone_owned();
                along.set_column(end, &before);
            }
            for row in next..row_of_end {
                square[end] += inside[row].powi(2) - outside[row].powi(2);
                let change = inside[row] - outside[row];
                along.column_mut(end).axpy(change, &self.basis.row(row).transpose(), 1.0);
            }
            next = row_of_end;
        }
        let squares_along =
            DVector::from_iterator(rows.len(), along.column_iter().map(|sum| sum.norm_squared()));
        let mut least: Option<([usize; 2], f64)> = None;
        for last in 1..rows.len() {
            // |Bᵀy|² of the window is |u − s|², with u from the beginning to its end and s to its first row.
            let to_last = &along_outside + along.column(last);
            let along_both = along.columns(0, last).tr_mul(&to_last);
            let whole = whole + square[last] - to_last.norm_squared();
            for first in 0..last {
                let left = whole - square[first] - squares_along[first] + 2.0 * along_both[first];
                if least.is_none_or(|(_, least)| left < least) {
                    least = Some(([first, last], left));
                }
            }
        }
        let (window, square) = least?;
        Some((window.map(|at| rows[at]), (square.max(0.0) / outside.len().max(1) as f64).sqrt()))
    }

    /// Rms of what it leaves with some more columns, mm.
    pub fn rms_with_mm(&self, columns: &DMatrix<f64>, readings_mm: &DVector<f64>) -> f64 {
        let new = orthonormal(&(columns - &self.directions * self.basis.tr_mul(columns)));
        let left_mm = self.left_mm(readings_mm);
        let left_mm = &left_mm - &new * new.tr_mul(&left_mm);
        let beyond = self.effects.iter().map(|effect| orthonormal(&off(effect, &new)));
        least_rms(&left_mm, beyond)
    }

    /// The least of these with one more error of one axis, of those that `may_be`, mm. Errors with shape numbers are not tried.
    pub fn rms_with_an_axis_mm(&self, experiment: &Experiment, may_be: impl Fn(&Instance) -> bool) -> f64 {
        let readings_mm = experiment.readings_mm();
        effects_of_an_axis(experiment, may_be)
            .map(|columns| self.rms_with_mm(&columns, &readings_mm))
            .fold(f64::INFINITY, f64::min)
    }

    /// What it leaves, rms, mm.
    pub fn rms_mm(&self, readings_mm: &DVector<f64>) -> f64 {
        least_rms(&self.left_mm(readings_mm), self.effects.iter())
    }
}

/// Columns of every effect of one axis without shape numbers that `may_be`.
fn effects_of_an_axis(
    experiment: &Experiment,
    may_be: impl Fn(&Instance) -> bool,
) -> impl Iterator<Item = DMatrix<f64>> {
    let scene = &experiment.scene;
    let is_of_axis = |instance: &Instance| {
        instance.subject() != Subject::Whole && !matches!(instance.role(), Role::Setting | Role::Description)
    };
    let can_be = |instance: &Instance| {
        !instance.parameters(scene).is_empty() && instance.shapes(scene).names.is_empty()
    };
    let all =
        Instance::all(experiment.machine()).into_iter().filter(is_of_axis).filter(can_be).filter(may_be);
    all.map(|instance| experiment.columns(&instance, &[]))
}

/// Rms of what one of several sets of orthonormal columns leaves at least: |r|² − |Eᵀr|².
fn least_rms(left_mm: &DVector<f64>, sets: impl Iterator<Item = impl Borrow<DMatrix<f64>>>) -> f64 {
    let most = sets.map(|set| set.borrow().tr_mul(left_mm).norm_squared()).fold(0.0, f64::max);
    ((left_mm.norm_squared() - most).max(0.0) / left_mm.len().max(1) as f64).sqrt()
}

pub(super) fn rms(of: &DVector<f64>) -> f64 {
    (of.norm_squared() / of.len().max(1) as f64).sqrt()
}
