//! The weighted columns of a joint model over all points: held in memory when short, formed block by block when long.

use crate::noise::weights::Weights;
use crate::problem::off_nominal;
use crate::problem::side_by_side::SideBySide;
use crate::solve::linear::Reduced;
use crate::{Experiment, IdentifyError};
use nalgebra::{DMatrix, DMatrixView, DVector};
use std::cell::OnceCell;
use std::ops::Range;

/// Designs up to this many rows are held in memory and factored by QR; longer ones are streamed.
const ROWS_IN_MEMORY: usize = 50_000;
/// Points formed at a time.
const BLOCK: usize = 512;

/// Receives points, their rows and the columns in these rows.
pub(crate) type Visit<'a> = &'a mut dyn FnMut(Range<usize>, Range<usize>, DMatrixView<'_, f64>);

pub(crate) struct Design<'a> {
    pub experiment: &'a Experiment,
    pub joint: &'a SideBySide,
    pub weights: &'a Weights,
    in_memory: Option<DMatrix<f64>>,
    off_nominal: OnceCell<DMatrix<f64>>,
}

impl<'a> Design<'a> {
    pub fn new(experiment: &'a Experiment, joint: &'a SideBySide, weights: &'a Weights) -> Self {
        let mut design = Self { experiment, joint, weights, in_memory: None, off_nominal: OnceCell::new() };
        if experiment.rows() <= ROWS_IN_MEMORY {
            design.in_memory = Some(design.columns(0..experiment.points.len()));
        }
        design
    }

    fn columns(&self, points: Range<usize>) -> DMatrix<f64> {
        let rows = self.experiment.rows_of_points(&points);
        let mut columns = self.joint.columns(self.experiment, points);
        if !self.weights.even {
            let root = self.weights.root.rows(rows.start, rows.len());
            columns.column_iter_mut().for_each(|mut column| column.component_mul_assign(&root));
        }
        columns
    }

    /// The points block by block, with their rows.
    pub fn stretches(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        let count = self.experiment.points.len();
        (0..count).step_by(BLOCK).map(move |start| {
            let points = start..(start + BLOCK).min(count);
            let rows = self.experiment.rows_of_points(&points);
            (points, rows)
        })
    }

    /// Visits the columns block by block: points, rows, columns in these rows.
    pub fn blocks(&self, visit: Visit<'_>) {
        for (points, rows) in self.stretches() {
            match &self.in_memory {
                Some(all) => visit(points, rows.clone(), all.rows(rows.start, rows.len()).as_view()),
                None => {
                    let columns = self.columns(points.clone());
                    visit(points, rows, columns.as_view());
                }
            }
        }
    }

    /// Aᵀ `changes` for the determined parameters.
    pub fn on_columns(&self, determined: &[usize], changes: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sums = DMatrix::zeros(determined.len(), changes.ncols());
        self.blocks(&mut |_, rows, columns| {
            let chosen = columns.select_columns(determined);
            sums.gemm_tr(1.0, &chosen, &changes.rows(rows.start, rows.len()), 1.0);
        });
        sums
    }

    /// The design of the used points, reduced.
    pub fn reduce(&self, used: &[bool]) -> Result<Reduced, IdentifyError> {
        if let Some(all) = &self.in_memory {
            let mut kept = all.clone();
            for row in self.experiment.unused_rows(used) {
                kept.row_mut(row).fill(0.0);
            }
            self.check_finite(0, &kept)?;
            return Ok(Reduced::from_design(&kept));
        }
        let mut gram = DMatrix::zeros(self.joint.width(), self.joint.width());
        let mut finite = Ok(());
        self.blocks(&mut |points, rows, columns| {
            let mut kept = columns.into_owned();
            for i in points.filter(|&i| !used[i]) {
                for row in self.experiment.rows_of(i) {
                    kept.row_mut(row - rows.start).fill(0.0);
                }
            }
            if finite.is_ok() {
                finite = self.check_finite(rows.start, &kept);
            }
            gram.gemm_tr(1.0, &kept, &kept, 1.0);
        });
        finite?;
        Ok(Reduced::from_gram(&gram))
    }

    /// ΔAᵀΔA of positions a little off, see [`crate::problem::off_nominal`].
    pub fn off_nominal(&self) -> &DMatrix<f64> {
        let Self { experiment, joint, weights, in_memory, .. } = self;
        self.off_nominal
            .get_or_init(|| off_nominal::gram(experiment, joint, &weights.root, in_memory.as_ref()))
    }

    /// A column that is no number would make the decompositions run forever.
    fn check_finite(&self, first_row: usize, columns: &DMatrix<f64>) -> Result<(), IdentifyError> {
        let Some(k) = columns.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        Err(self.experiment.not_finite(first_row + k % columns.nrows(), "prediction"))
    }

    /// Qᵀ of a residual; rows of unused points must be zero.
    pub fn project(&self, reduced: &Reduced, residual: &DVector<f64>) -> DVector<f64> {
        if reduced.wants_rows() {
            return reduced.project(residual);
        }
        let mut normal = DVector::zeros(self.joint.width());
        self.blocks(&mut |_, rows, columns| {
            normal.gemv_tr(1.0, &columns, &residual.rows(rows.start, rows.len()), 1.0);
        });
        reduced.project(&normal)
    }
}
