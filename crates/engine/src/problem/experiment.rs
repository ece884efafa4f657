//! Runs fitted together: their points, rows and columns.
//!
//! Row layout: points in order of the runs, the components of each point together (3 for an R-test, 1 for a ball
//! bar). Column of parameter j of an effect: `Σ_sites projection · propagation · twist_j(state)` (docs/design/physics.md §2).

use crate::IdentifyError;
use crate::problem::poses::{same_pose, stood};
use nalgebra::{DMatrix, DMatrixViewMut, DVector, Matrix3};
use std::borrow::Cow;
use std::ops::Range;
use trunnion_core::{AxisValues, Joint, Point, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, Scene};
use trunnion_instruments::Projector;
use trunnion_machine::Machine;

/// Points of one or more runs of one machine.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// What effects may know.
    pub scene: Scene,
    /// Setups of all runs; `Point::state.setup` indexes them.
    pub setups: Vec<Setup>,
    /// Good points of all runs; setups renumbered.
    pub points: Vec<Point>,
    /// Which run each point came from.
    pub run_of_point: Vec<usize>,
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Kind of each run.
    pub kinds: Vec<RunKind>,
    /// Readings behind a point of each run at rest, the mean: more than 1 where points were reduced to means.
    readings: Vec<f64>,
    first_row: Vec<usize>,
}

/// Share of a shape number that a secant covers at most on each side: less than leads to zero. Beyond it a linear covariance says nothing.
pub(crate) const SECANT: f64 = 0.5;
/// The same at least: more than rounding.
const TANGENT: f64 = 1e-4;

impl Experiment {
    /// Lays points out in rows, with the run of each; `setups` and `scene` are those of all runs.
    pub(super) fn laid_out(
        runs: &[&Run],
        scene: Scene,
        setups: Vec<Setup>,
        points: Vec<Point>,
        run_of_point: Vec<usize>,
    ) -> Self {
        let components = |point: &Point| setups[point.state.setup].instrument.components().len();
        let first_row = first_rows(points.iter().map(components));
        let kinds = runs.iter().map(|run| run.kind).collect();
        let readings = vec![1.0; runs.len()];
        let runs = runs.iter().map(|run| run.name.clone()).collect();
        Self { scene, setups, points, run_of_point, runs, kinds, readings, first_row }
    }

    /// The same, where points of runs at rest are means of so many readings more, one number for each run.
    #[must_use]
    pub fn of_means(mut self, readings: &[f64]) -> Self {
        self.readings.iter_mut().zip(readings).for_each(|(mine, more)| *mine *= more);
        self
    }

    /// Readings that are averaged in a point, the mean over all points; the samples of a block count each.
    pub(crate) fn readings_of_point(&self) -> f64 {
        let of_point = |(point, &run): (&Point, &usize)| match self.kinds[run] {
            RunKind::OnTheFly => f64::from(point.samples.max(1)),
            RunKind::Static => self.readings[run],
        };
        let sum: f64 = self.points.iter().zip(&self.run_of_point).map(of_point).sum();
        sum / self.points.len().max(1) as f64
    }

    /// The same with some of its points only, one flag for each; ranges of the scene stay those of all.
    #[must_use]
    pub fn kept(&self, keep: &[bool]) -> Self {
        let chosen = |i: &usize| keep[*i];
        let indices: Vec<usize> = (0..self.points.len()).filter(chosen).collect();
        let first_row = first_rows(indices.iter().map(|&i| self.rows_of(i).len()));
        Self {
            points: indices.iter().map(|&i| self.points[i].clone()).collect(),
            run_of_point: indices.iter().map(|&i| self.run_of_point[i]).collect(),
            first_row,
            ..self.clone()
        }
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        &self.scene.machine
    }

    /// Number of scalar readings.
    pub fn rows(&self) -> usize {
        self.first_row[self.points.len()]
    }

    /// Rows of one point.
    pub fn rows_of(&self, point: usize) -> Range<usize> {
        self.first_row[point]..self.first_row[point + 1]
    }

    /// Rows of the points that take no part in a fit.
    pub fn unused_rows(&self, used: &[bool]) -> impl Iterator<Item = usize> {
        (0..used.len()).filter(|&i| !used[i]).flat_map(|i| self.rows_of(i))
    }

    /// Number of the pose of each point, by all joints; those of different setups differ.
    pub fn poses(&self) -> Vec<usize> {
        let setup = self.points.iter().map(|point| point.state.setup).collect();
        same_pose(setup, &self.all_positions(), &self.machine().joints())
    }

    /// Number of the stand of each point, by some joints alone.
    pub(crate) fn stands(&self, joints: &[Joint]) -> Vec<usize> {
        same_pose(vec![0; self.points.len()], &self.all_positions(), joints)
    }

    fn all_positions(&self) -> Vec<&AxisValues<f64>> {
        self.points.iter().map(|point| &point.state.position).collect()
    }

    /// Where a joint stood at every row, mm or rad; positions that scatter about one stand are its mean.
    pub(crate) fn positions(&self, joint: Joint) -> Vec<f64> {
        let stood = stood(&self.all_positions(), joint);
        let of_point = |(i, position): (usize, f64)| self.rows_of(i).map(move |_| position);
        stood.into_iter().enumerate().flat_map(of_point).collect()
    }

    /// Readings, mm.
    pub fn readings_mm(&self) -> DVector<f64> {
        let mut readings = DVector::zeros(self.rows());
        for (i, point) in self.points.iter().enumerate() {
            for (k, row) in self.rows_of(i).enumerate() {
                readings[row] = point.reading_mm[k];
            }
        }
        readings
    }

    /// Standard error of every reading by what its samples say, mm; zero when unknown.
    pub fn standard_errors_mm(&self) -> DVector<f64> {
        let mut errors = DVector::zeros(self.rows());
        for (i, point) in self.points.iter().enumerate() {
            let of_point = point.standard_error_mm();
            for (k, row) in self.rows_of(i).enumerate() {
                errors[row] = of_point[k];
            }
        }
        errors
    }

    /// The error of a row that is no number.
    pub(crate) fn not_finite(&self, row: usize, what: &'static str) -> IdentifyError {
        let point = self.first_row.partition_point(|first| *first <= row) - 1;
        IdentifyError::NotFinite { point, run: self.runs[self.run_of_point[point]].clone(), what }
    }

    /// Columns of one effect: rows × parameters, mm per unit of the parameter (inside units).
    pub fn columns(&self, instance: &Instance, shape: &[f64]) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.rows(), instance.parameters(&self.scene).len());
        self.add_columns(&[(instance, shape)], 0..self.points.len(), &mut columns);
        columns
    }

    /// What one shape number of an effect changes in its readings, to first order in its `values` (inside units): mm per unit of it, a secant
    /// over ± `u`, half of it at most: it is a time, a length, a count of cycles, and above zero.
    pub fn change_with_shape(
        &self,
        instance: &Instance,
        shape: &[f64],
        at: usize,
        u: f64,
        values: &DVector<f64>,
    ) -> DVector<f64> {
        let [least, most] = [TANGENT, SECANT].map(|share| share * shape[at].abs());
        let step = u.clamp(least, most);
        let [mut less, mut more] = [shape.to_vec(), shape.to_vec()];
        (less[at], more[at]) = (shape[at] - step, shape[at] + step);
        let mut change = DVector::zeros(self.rows());
        for i in 0..self.points.len() {
            let rows = self.rows_of(i);
            let mut columns = DMatrix::zeros(rows.len(), 2 * values.len());
            self.add_columns(&[(instance, &more), (instance, &less)], i..i + 1, &mut columns);
            let of_point = columns.columns(0, values.len()) - columns.columns(values.len(), values.len());
            change.rows_mut(rows.start, rows.len()).gemv(0.5 / step, &of_point, values, 0.0);
        }
        change
    }

    /// What the instrument of a point sees of a small displacement of the tool against the table, machine axes: rows its
    /// components, mm per mm; rows it has not are zero.
    pub fn seen_of_tool(&self, point: usize) -> Matrix3<f64> {
        let state = &self.points[point].state;
        Projector::new(self.machine(), &self.setups[state.setup], state).seen()
    }

    /// Rows of `points`.
    pub fn rows_of_points(&self, points: &Range<usize>) -> Range<usize> {
        self.first_row[points.start]..self.first_row[points.end]
    }

    /// Adds the columns of `effects`, side by side, in the rows of `points` to `columns`, whose first row is
    /// the first row of `points`.
    pub fn add_columns(
        &self,
        effects: &[(&Instance, &[f64])],
        points: Range<usize>,
        columns: &mut DMatrix<f64>,
    ) {
        self.add_columns_at(&|i| Cow::Borrowed(&self.points[i].state), effects, points, columns);
    }

    /// The same with the points in other states.
    pub(crate) fn add_columns_at<'s>(
        &self,
        state_of: &dyn Fn(usize) -> Cow<'s, State>,
        effects: &[(&Instance, &[f64])],
        points: Range<usize>,
        columns: &mut DMatrix<f64>,
    ) {
        let first_row = self.first_row[points.start];
        let place = Place { effects, first_column: self.first_columns(effects) };
        for i in points {
            let rows = self.rows_of(i);
            let state: &State = &state_of(i);
            let projector = Projector::new(self.machine(), &self.setups[state.setup], state);
            let at = rows.start - first_row;
            place.add(&self.scene, &projector, state, &mut columns.rows_mut(at, rows.len()));
        }
    }

    fn first_columns(&self, effects: &[(&Instance, &[f64])]) -> Vec<usize> {
        let mut first_column = vec![0];
        for (instance, _) in effects {
            first_column.push(first_column[first_column.len() - 1] + instance.parameters(&self.scene).len());
        }
        first_column
    }

    /// Columns of one effect as [`Experiment::columns`], with what the instruments see at every point.
    pub(crate) fn columns_seen(
        &self,
        projectors: &[Projector<'_>],
        instance: &Instance,
        shape: &[f64],
    ) -> DMatrix<f64> {
        let effects = [(instance, shape)];
        let place = Place { effects: &effects, first_column: self.first_columns(&effects) };
        let mut columns = DMatrix::zeros(self.rows(), place.first_column[1]);
        for (i, projector) in projectors.iter().enumerate() {
            let (rows, state) = (self.rows_of(i), &self.points[i].state);
            place.add(&self.scene, projector, state, &mut columns.rows_mut(rows.start, rows.len()));
        }
        columns
    }

    /// What the instruments see at every point.
    pub(crate) fn projectors(&self) -> Vec<Projector<'_>> {
        let of_point = |point: &Point| {
            let state = &point.state;
            Projector::new(self.machine(), &self.setups[state.setup], state)
        };
        self.points.iter().map(of_point).collect()
    }
}

/// Effects side by side, with the first column of each.
struct Place<'e> {
    effects: &'e [(&'e Instance, &'e [f64])],
    first_column: Vec<usize>,
}

impl Place<'_> {
    /// Adds what they make of one point to its rows.
    fn add(
        &self,
        scene: &Scene,
        projector: &Projector<'_>,
        state: &State,
        rows: &mut DMatrixViewMut<'_, f64>,
    ) {
        for (first_column, (instance, shape)) in self.first_column.iter().zip(self.effects) {
            instance.motions(scene, shape, state, &mut |parameter, site, twist| {
                let seen = projector.column(site, &twist);
                for component in 0..rows.nrows() {
                    rows[(component, first_column + parameter)] += seen[component];
                }
            });
        }
    }
}

/// Row where each point begins, and where the last one ends, from how many rows each has.
fn first_rows(of_points: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut first_row = vec![0];
    for rows in of_points {
        first_row.push(first_row[first_row.len() - 1] + rows);
    }
    first_row
}
