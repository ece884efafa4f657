//! In what a kernel acts: the readings themselves, the axes of the machine, the angle at which an axis stops.

use super::Real;
use crate::Experiment;
use crate::noise::machine_noise::{ground_joint, unit_columns};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;
use trunnion_core::{AxisValues, Joint};
use trunnion_instruments::Projector;
use trunnion_machine::Site;

/// A lever that is smaller moves no reading: rounding.
const LEAST_LEVER: f64 = 1e-9;

/// In what a kernel acts.
pub(crate) struct Frame {
    /// Row × direction; mean square 1 over the rows.
    lever: DMatrix<Real>,
    points: usize,
    point_of_row: Arc<[usize]>,
}

impl Frame {
    /// `None` where it moves no reading.
    pub fn new(lever: &DMatrix<f64>, points: usize, point_of_row: Arc<[usize]>) -> Option<Self> {
        let size = lever.norm() / (lever.nrows() as f64).sqrt();
        (size >= LEAST_LEVER).then(|| Self { lever: (lever / size).cast(), points, point_of_row })
    }

    /// The same on some of the points.
    pub fn on(&self, rows: &[usize], points: usize, point_of_row: Arc<[usize]>) -> Self {
        Self { lever: self.lever.select_rows(rows), points, point_of_row }
    }

    /// A column of lever · leverᵀ on some rows. The whole is as large as a covariance and as quickly computed as read.
    pub fn gram(&self, column: usize, rows: Range<usize>, into: &mut Vec<Real>) {
        into.clear();
        into.resize(rows.len(), 0.0);
        for of_direction in self.lever.as_slice().chunks_exact(self.lever.nrows()) {
            let here = of_direction[column];
            if here != 0.0 {
                into.iter_mut()
                    .zip(&of_direction[rows.clone()])
                    .for_each(|(sum, lever)| *sum += here * lever);
            }
        }
    }

    /// Adds the diagonal of lever · leverᵀ times `by`.
    pub fn add_squares(&self, by: f64, to: &mut DVector<f64>) {
        for lever in self.lever.column_iter() {
            to.zip_apply(&lever, |sum, lever| *sum += by * f64::from(lever).powi(2));
        }
    }

    /// Sums over the rows of each point of lever ∘ v: point × direction.
    pub fn folded(&self, v: &DVector<Real>) -> DMatrix<Real> {
        let mut sums = DMatrix::zeros(self.points, self.lever.ncols());
        for (row, &point) in self.point_of_row.iter().enumerate() {
            for k in 0..self.lever.ncols() {
                sums[(point, k)] += self.lever[(row, k)] * v[row];
            }
        }
        sums
    }

    /// The same of several columns: point × column, the directions next to each other.
    pub fn folded_columns(&self, columns: &DMatrix<Real>) -> DMatrix<Real> {
        let width = columns.ncols();
        let mut sums = DMatrix::zeros(self.points, width * self.lever.ncols());
        for (lever, first) in self.lever.column_iter().zip((0..).step_by(width.max(1))) {
            let mut sums = sums.columns_mut(first, width);
            for (mut sums, column) in sums.column_iter_mut().zip(columns.column_iter()) {
                for (row, &point) in self.point_of_row.iter().enumerate() {
                    sums[point] += lever[row] * column[row];
                }
            }
        }
        sums
    }

    /// Adds to every row lever · the values of its point, column by column; `values`: the directions next to each other.
    pub fn add_unfolded(&self, values: &DMatrix<Real>, to: &mut DMatrix<Real>) {
        let width = to.ncols();
        for (lever, first) in self.lever.column_iter().zip((0..).step_by(width.max(1))) {
            let values = values.columns(first, width);
            for (mut to, values) in to.column_iter_mut().zip(values.column_iter()) {
                for (row, &point) in self.point_of_row.iter().enumerate() {
                    to[row] += lever[row] * values[point];
                }
            }
        }
    }

    /// Back to rows: lever · values of the row's point.
    pub fn unfolded(&self, values: &DMatrix<Real>) -> DVector<Real> {
        let of_row = |(row, &point): (usize, &usize)| {
            (0..self.lever.ncols()).map(|k| self.lever[(row, k)] * values[(point, k)]).sum::<Real>()
        };
        DVector::from_iterator(self.point_of_row.len(), self.point_of_row.iter().enumerate().map(of_row))
    }
}

/// Each component of a reading by itself, alike in all instruments that read it.
pub(super) fn of_readings(experiment: &Experiment) -> DMatrix<f64> {
    let names: Vec<&str> = experiment
        .points
        .iter()
        .enumerate()
        .flat_map(|(i, point)| {
            let components = experiment.scene.setups[point.state.setup].components;
            components.iter().copied().take(experiment.rows_of(i).len())
        })
        .collect();
    let mut distinct: Vec<&str> = names.clone();
    distinct.sort_unstable();
    distinct.dedup();
    DMatrix::from_fn(names.len(), distinct.len(), |row, k| f64::from(names[row] == distinct[k]))
}

/// Displacement of the tool against the table along the axes of the machine.
pub(super) fn of_machine(experiment: &Experiment) -> DMatrix<f64> {
    let (ground, _) = ground_joint(experiment.machine(), &AxisValues::default());
    DMatrix::from_columns(&[0, 1, 2].map(|k| unit_columns(experiment, ground, k)))
}

/// The angle at which an axis stops.
pub(super) fn of_axis(experiment: &Experiment, letter: Joint) -> DMatrix<f64> {
    let mut lever = DMatrix::zeros(experiment.rows(), 1);
    let Some(axis) = experiment.machine().axis(letter) else { return lever };
    for (i, point) in experiment.points.iter().enumerate() {
        let setup = &experiment.setups[point.state.setup];
        let projector = Projector::new(experiment.machine(), setup, &point.state);
        let seen = projector.column(Site::Joint(letter), &axis.positioning_twist());
        for (k, row) in experiment.rows_of(i).enumerate() {
            lever[(row, 0)] = seen[k];
        }
    }
    lever
}
