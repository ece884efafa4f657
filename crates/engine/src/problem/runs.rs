//! Runs put together into an experiment: points of long runs reduced, setups renumbered, deflections of the probes predicted.

use crate::fit::{Options, identify};
use crate::problem::experiment::Experiment;
use crate::problem::off_nominal::OFF_MM;
use crate::problem::side_by_side::SideBySide;
use crate::problem::stream::{blocks_of, many, stations_of};
use nalgebra::{DVector, Vector3};
use std::borrow::{Borrow, Cow};
use trunnion_core::{NestSide, Point, Setup};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::{Model, Scene, SceneArtefact, SceneSetting, SceneSetup, Unit};
use trunnion_instruments::{Quantity, instrument, off_spindle};
use trunnion_machine::{Machine, Side};
use trunnion_sync::blocks::Limits;

/// Nominal readings up to this are those of positions a little off: three linear axes by [`OFF_MM`] each, rotary axes as much again.
const NO_STEP_MM: f64 = 6.0 * OFF_MM;

/// Runs that cannot be fitted together.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ExperimentError {
    /// No run was given.
    #[error("there is no run to identify from; name at least one recording")]
    NoRun,
    /// No usable point.
    #[error(
        "{runs}: no usable point; `trunnion export csv RUN --what every-point` lists what each of them lacks"
    )]
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
        let mut experiment = Self::undeflected(runs)?;
        experiment.predict_deflections();
        Ok(experiment)
    }

    /// The same without deflections of the probes, for effects that do not ask for them.
    pub(crate) fn undeflected(runs: &[Run]) -> Result<Self, ExperimentError> {
        let limits = Limits::default();
        let reduced = |run: &'_ Run| match run.kind {
            RunKind::OnTheFly => blocks_of(run, limits).0,
            RunKind::Static => stations_of(run, limits),
        };
        let fitted = runs.iter().map(|run| match many(run, limits) {
            true => Cow::Owned(reduced(run)),
            false => Cow::Borrowed(run),
        });
        let fitted: Vec<Cow<'_, Run>> = fitted.collect();
        let good = |run: &Run| run.good_points().count().max(1) as f64;
        let readings: Vec<f64> =
            runs.iter().zip(&fitted).map(|(run, fitted)| good(run) / good(fitted)).collect();
        Ok(Self::put_together(&fitted)?.of_means(&readings))
    }

    /// As [`Self::new`], with every point as it is, however many.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_points(runs: &[impl Borrow<Run>]) -> Result<Self, ExperimentError> {
        let mut experiment = Self::put_together(runs)?;
        experiment.predict_deflections();
        Ok(experiment)
    }

    fn put_together(runs: &[impl Borrow<Run>]) -> Result<Self, ExperimentError> {
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
                settings: settings(&first.machine, setup),
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
        Ok(Self::laid_out(&runs, scene, setups, points, run_of_point))
    }

    /// What the probes were asked to read, as the base model predicts it: known steps and the linear columns times what was fitted. Never
    /// the readings themselves: an effect of the probes would then explain every reading by itself. Nor the exact prediction: what it
    /// holds of second order no column has, so a gain would be seen by that alone, 1000 µm/mm of it. Nominal readings that positions a
    /// little off would give (`problem::off_nominal`) are no known steps: a gain would follow their rounding and scatter.
    fn predict_deflections(&mut self) {
        let base = Model::base(&self.machine().name);
        let Ok(fit) = identify(self, &base, &Options::quick()) else { return };
        let Ok(joint) = SideBySide::place(self, &base) else { return };
        let mut steps_mm = joint.predict_mm(self, &DVector::zeros(joint.width()));
        let deflects = |i: usize| self.setups[self.points[i].state.setup].instrument.deflects_probes();
        let deflected: Vec<usize> = (0..self.points.len()).filter(|&i| deflects(i)).collect();
        let rows = deflected.iter().flat_map(|&i| self.rows_of(i));
        if rows.map(|row| steps_mm[row].abs()).fold(0.0, f64::max) <= NO_STEP_MM {
            steps_mm.fill(0.0);
        }
        for i in deflected {
            let of_errors_mm = joint.columns(self, i..i + 1) * &fit.solution;
            for (k, row) in self.rows_of(i).enumerate() {
                self.points[i].state.deflection_mm[k] = steps_mm[row] + of_errors_mm[k];
            }
        }
        let states = self.points.iter().map(|p| &p.state);
        let (machine, setups) = (self.scene.machine.clone(), self.scene.setups.clone());
        self.scene = Scene::new(machine, setups, self.scene.channels.clone(), states);
    }
}

/// Unknowns of a mounting, as effects see them.
fn settings(machine: &Machine, setup: &Setup) -> Vec<SceneSetting> {
    let unit = |quantity: Quantity| match quantity {
        Quantity::Length => Unit::UM,
        Quantity::Angle => Unit::URAD,
    };
    let in_spindle = machine.spindle.map(|_| off_spindle(setup.instrument));
    (instrument(setup.instrument).settings)(setup)
        .into_iter()
        .chain(in_spindle.into_iter().flatten())
        .map(|s| SceneSetting {
            name: s.name,
            unit: unit(s.quantity),
            site: s.site,
            twist: s.twist,
            u_beforehand: s.u_beforehand,
        })
        .collect()
}
