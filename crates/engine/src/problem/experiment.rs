//! Runs fitted together: their points, rows and columns.
//!
//! Row layout: points in order of the runs, the components of each point together (3 for an R-test, 1 for a ball
//! bar). Column of parameter j of an effect: `Σ_sites projection · propagation · twist_j(state)` (docs/design/physics.md §2).

use crate::IdentifyError;
use crate::fit::Options;
use crate::problem::stream::{blocks_of, many, stations_of};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::borrow::{Borrow, Cow};
use std::ops::Range;
use trunnion_core::{NestSide, Point, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Instance, Model, Scene, SceneArtefact, SceneSetting, SceneSetup, Unit};
use trunnion_instruments::{Projector, Quantity, instrument};
use trunnion_machine::{Machine, Side};
use trunnion_sync::blocks::Limits;

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
    first_row: Vec<usize>,
}

/// Runs that cannot be fitted together.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ExperimentError {
    /// No run was given.
    #[error("there is no run to identify from; name at least one recording")]
    NoRun,
    /// No usable point.
    #[error("the runs {runs} hold no usable point; look at their quality with `trunnion compare`")]
    NoPoints {
        /// Names of the runs.
        runs: String,
    },
    /// Two machines.
    #[error(
        "run {run} was measured on machine {found}, run {first} on {expected}; fit runs of one machine together"
    )]
    DifferentMachines {
        /// The run that differs.
        run: String,
        /// Its machine.
        found: String,
        /// The first run.
        first: String,
        /// Its machine.
        expected: String,
    },
}

impl Experiment {
    /// Puts runs together; one with more points than [`Limits`] allows for its kind is reduced to blocks or stations first. Setups of
    /// different runs stay apart (the ball was set again); with several runs their names are prefixed by the run's number, e.g. `1.low`.
    ///
    /// # Errors
    /// No run, no usable point, or runs of different machines.
    pub fn new(runs: &[Run]) -> Result<Self, ExperimentError> {
        let limits = Limits::default();
        let reduced = |run: &'_ Run| match run.kind {
            RunKind::OnTheFly => blocks_of(run, limits).0,
            RunKind::Static => stations_of(run, limits),
        };
        let fitted = runs.iter().map(|run| match many(run, limits) {
            true => Cow::Owned(reduced(run)),
            false => Cow::Borrowed(run),
        });
        Self::of_points(&fitted.collect::<Vec<_>>())
    }

    /// As [`Self::new`], with every point as it is, however many.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_points(runs: &[impl Borrow<Run>]) -> Result<Self, ExperimentError> {
        let runs: Vec<&Run> = runs.iter().map(Borrow::borrow).collect();
        let first = *runs.first().ok_or(ExperimentError::NoRun)?;
        let (mut setups, mut points, mut run_of_point, mut channels) =
            (Vec::new(), Vec::new(), Vec::new(), first.channels.clone());
        let mut run_of_setup = Vec::new();
        for (i, run) in runs.iter().copied().enumerate() {
            if run.machine != first.machine {
                return Err(ExperimentError::DifferentMachines {
                    run: run.name.clone(),
                    found: run.machine.name.clone(),
                    first: first.name.clone(),
                    expected: first.machine.name.clone(),
                });
            }
            let offset = setups.len();
            for setup in &run.setups {
                let name =
                    if runs.len() > 1 { format!("{}.{}", i + 1, setup.name) } else { setup.name.clone() };
                setups.push(Setup { name, ..setup.clone() });
                run_of_setup.push(i);
            }
            channels.retain(|channel| run.channels.contains(channel));
            for point in run.good_points() {
                let mut point = point.clone();
                point.state.setup += offset;
                points.push(point);
                run_of_point.push(i);
            }
        }
        // Channels that not every run has would leave holes: only common ones take part.
        for (point, &i) in points.iter_mut().zip(&run_of_point) {
            let all = &point.state.temperature_degc;
            let common = channels
                .iter()
                .filter_map(|c| runs[i].channels.iter().position(|x| x == c))
                .filter_map(|k| all.get(k).copied());
            point.state.temperature_degc = common.collect();
        }
        if points.is_empty() {
            let runs = runs.iter().map(|run| run.name.clone()).collect::<Vec<_>>().join(", ");
            return Err(ExperimentError::NoPoints { runs });
        }
        let scene_setups = setups
            .iter()
            .zip(&run_of_setup)
            .map(|(setup, &run): (&Setup, _)| SceneSetup {
                name: setup.name.clone(),
                components: setup.instrument.components(),
                nest: match setup.nest {
                    NestSide::Table => Side::Table,
                    NestSide::Spindle => Side::Tool,
                },
                ball_in_table_mm: setup.ball_in_table_mm,
                run,
                settings: settings(setup),
                artefact: setup.artefact.as_ref().map(|artefact| SceneArtefact {
                    name: artefact.name.clone(),
                    targets: artefact.targets.iter().map(|target| target.name.clone()).collect(),
                    table_from_artefact: artefact.table_from_artefact(),
                }),
            })
            .collect();
        for point in &mut points {
            point.state.deflection_mm = Vector3::zeros();
        }
        let states = points.iter().map(|p: &Point| &p.state);
        let scene = Scene::new(first.machine.clone(), scene_setups, channels, states);
        let mut first_row = vec![0];
        for point in &points {
            let components = setups[point.state.setup].instrument.components().len();
            first_row.push(first_row[first_row.len() - 1] + components);
        }
        let names = runs.iter().map(|run| run.name.clone()).collect();
        let kinds = runs.iter().map(|run| run.kind).collect();
        let mut experiment = Self { scene, setups, points, run_of_point, runs: names, kinds, first_row };
        experiment.predict_deflections();
        Ok(experiment)
    }

    /// The same with some of its points only, one flag for each; ranges of the scene stay those of all.
    #[must_use]
    pub fn kept(&self, keep: &[bool]) -> Self {
        let chosen = |i: &usize| keep[*i];
        let indices: Vec<usize> = (0..self.points.len()).filter(chosen).collect();
        let mut first_row = vec![0];
        for &i in &indices {
            first_row.push(first_row[first_row.len() - 1] + self.rows_of(i).len());
        }
        Self {
            points: indices.iter().map(|&i| self.points[i].clone()).collect(),
            run_of_point: indices.iter().map(|&i| self.run_of_point[i]).collect(),
            first_row,
            ..self.clone()
        }
    }

    /// What the probes were asked to read, as the base model predicts it. Never the readings themselves: an
    /// effect of the probes would then explain every reading by itself.
    fn predict_deflections(&mut self) {
        let base = Model::base(&self.machine().name);
        let Ok(fit) = crate::identify(self, &base, &Options::quick()) else { return };
        for i in 0..self.points.len() {
            if !self.setups[self.points[i].state.setup].instrument.deflects_probes() {
                continue;
            }
            for (k, row) in self.rows_of(i).enumerate() {
                self.points[i].state.deflection_mm[k] = fit.predicted_mm[row];
            }
        }
        let states = self.points.iter().map(|p| &p.state);
        let (machine, setups) = (self.scene.machine.clone(), self.scene.setups.clone());
        self.scene = Scene::new(machine, setups, self.scene.channels.clone(), states);
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
        let mut first_column = vec![0];
        for (instance, _) in effects {
            first_column.push(first_column[first_column.len() - 1] + instance.parameters(&self.scene).len());
        }
        for i in points {
            let rows = self.rows_of(i);
            let state: &State = &state_of(i);
            let projector = Projector::new(self.machine(), &self.setups[state.setup], state);
            for (k, (instance, shape)) in effects.iter().enumerate() {
                instance.motions(&self.scene, shape, state, &mut |parameter, site, twist| {
                    let seen = projector.column(site, &twist);
                    for (component, row) in rows.clone().enumerate() {
                        columns[(row - first_row, first_column[k] + parameter)] += seen[component];
                    }
                });
            }
        }
    }
}

/// Unknowns of a mounting, as effects see them.
fn settings(setup: &Setup) -> Vec<SceneSetting> {
    let unit = |quantity: Quantity| match quantity {
        Quantity::Length => Unit::UM,
        Quantity::Angle => Unit::URAD,
    };
    (instrument(setup.instrument).settings)(setup)
        .into_iter()
        .map(|s| SceneSetting { name: s.name, unit: unit(s.quantity), site: s.site, twist: s.twist })
        .collect()
}
