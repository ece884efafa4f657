//! The data at hand, thinned for planning, and the same together with a run that has not been measured yet.

use super::information::finite;
use super::options::PlanError;
use crate::fit::identification::Identification;
use crate::problem::Problem;
use crate::problem::experiment::Experiment;
use crate::problem::last_run::part_of;
use nalgebra::{DMatrix, DVector, Vector3};
use trunnion_core::{Point, Quality, Setup, State};
use trunnion_cycles::{Run, RunKind};
use trunnion_effects::catalogue::LOCATION_ERRORS;
use trunnion_effects::{Instance, Scene};
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// The data at hand.
pub(super) struct Present {
    /// Runs without outliers, at most so many points each.
    runs: Vec<Run>,
    pub experiment: Experiment,
    /// What the model leaves of the readings.
    pub residual_mm: DVector<f64>,
    model: Vec<ModelPart>,
    fit: Identification,
}

/// One effect of the model as fitted.
struct ModelPart {
    instance: Instance,
    shape: Vec<f64>,
    /// Parameters held at a value.
    held: Vec<String>,
}

impl Present {
    pub fn new(problem: &Problem<'_>, most_points: usize) -> Result<Self, PlanError> {
        let (experiment, model, fit) = (problem.experiment(), problem.model(), problem.fit().clone());
        let (mut runs, mut residual) = (Vec::new(), Vec::new());
        for run in 0..experiment.runs.len() {
            let own: Vec<usize> = (0..experiment.points.len())
                .filter(|&i| experiment.run_of_point[i] == run && fit.used[i])
                .collect();
            let stride = own.len().div_ceil(most_points).max(1);
            let kept: Vec<usize> = own.into_iter().step_by(stride).collect();
            if kept.is_empty() {
                continue;
            }
            residual.extend(kept.iter().flat_map(|&i| experiment.rows_of(i)).map(|row| fit.residual_mm[row]));
            runs.push(part_of(experiment, run, &kept));
        }
        let thinned = Experiment::new(&runs)?;
        let mut parts = Vec::new();
        for (entry, fitted) in model.effects.iter().zip(&fit.effects) {
            let instance = Instance::from_model_effect(entry, experiment.machine())?;
            let held = entry.fixed.iter().map(|(name, _)| name.clone()).collect();
            parts.push(ModelPart { instance, shape: fitted.shape.clone(), held });
        }
        Ok(Self { runs, experiment: thinned, residual_mm: DVector::from_vec(residual), model: parts, fit })
    }

    /// Columns of the free parameters of the model in an experiment.
    pub fn model_columns(&self, experiment: &Experiment) -> DMatrix<f64> {
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for part in &self.model {
            let all = finite(experiment.columns(&part.instance, &part.shape));
            for (j, parameter) in part.instance.parameters(&experiment.scene).iter().enumerate() {
                if !part.held.contains(&parameter.name) {
                    columns.push(all.column(j).into_owned());
                }
            }
        }
        DMatrix::from_columns(&columns)
    }

    /// The data at hand and one more run in these states, its ball mounted again, for these rivals. What probes will be asked to read
    /// takes a fit of all of it; it is left out where no effect follows it.
    pub fn with(
        &self,
        setups: &[Setup],
        states: &[State],
        kind: RunKind,
        rivals: &[Instance],
    ) -> Result<Experiment, PlanError> {
        let scene = &self.experiment.scene;
        let machine = self.experiment.machine().clone();
        let last = self.runs.last().and_then(|run| run.points.last());
        let temperature_degc = last.map(|point| point.state.temperature_degc.clone()).unwrap_or_default();
        let points = states
            .iter()
            .map(|state| {
                let state = State { temperature_degc: temperature_degc.clone(), ..state.clone() };
                let reading = predict(&machine, &setups[state.setup], &state, &self.errors_at(&state));
                Point {
                    state,
                    reading_mm: reading.into(),
                    spread_mm: [0.0; 3],
                    samples: 0,
                    quality: Quality::Good,
                }
            })
            .collect();
        let next = Run {
            name: "next".into(),
            machine,
            kind,
            setups: setups.into(),
            channels: scene.channels.clone(),
            points,
        };
        let mut runs = self.runs.clone();
        runs.push(next);
        let mut effects = self.model.iter().map(|part| &part.instance).chain(rivals);
        match effects.any(|instance| follows_deflections(instance, scene)) {
            true => Ok(Experiment::new(&runs)?),
            false => Ok(Experiment::undeflected(&runs)?),
        }
    }

    /// The location errors found so far: what the next readings will mostly be.
    fn errors_at(&self, state: &State) -> Errors {
        let mut errors = Errors::default();
        let Some(part) = self.model.iter().find(|part| part.instance.id() == LOCATION_ERRORS) else {
            return errors;
        };
        let of_effect = |k: &usize| self.fit.parameters[*k].effect == LOCATION_ERRORS;
        let indices: Vec<usize> = (0..self.fit.parameters.len()).filter(of_effect).collect();
        part.instance.motions(&self.experiment.scene, &part.shape, state, &mut |j, site, twist| {
            if let Some(&k) = indices.get(j) {
                errors.add(site, twist * self.fit.solution[k]);
            }
        });
        errors
    }

    /// Setups of the last run, for candidate cycles.
    pub fn last_setups(&self) -> &[Setup] {
        self.runs.last().map_or(&[], |run| &run.setups)
    }

    /// States of the last run, to measure the same once more.
    pub fn last_states(&self) -> Vec<State> {
        self.runs.last().map_or(Vec::new(), |run| run.points.iter().map(|p| p.state.clone()).collect())
    }

    /// Kind of the last run.
    pub fn last_kind(&self) -> RunKind {
        self.runs.last().map_or(RunKind::Static, |run| run.kind)
    }
}

/// Whether an effect follows what probes are asked to read: without it, it has fewer parameters.
fn follows_deflections(instance: &Instance, scene: &Scene) -> bool {
    let parameters = |deflection_mm| instance.parameters(&Scene { deflection_mm, ..scene.clone() }).len();
    parameters(Vector3::repeat(1.0)) != parameters(Vector3::zeros())
}
