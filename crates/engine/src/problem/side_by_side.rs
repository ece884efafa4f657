//! The effects of a model placed side by side: names, columns, exact prediction.

use crate::solve::null_space::Free;
use crate::{Experiment, Identification, IdentifyError};
use nalgebra::{DMatrix, DVector, Vector3};
use std::borrow::Cow;
use std::ops::Range;
use trunnion_core::State;
use trunnion_effects::{Instance, Model, ModelEffect, Parameter, Role, Shapes};
use trunnion_instruments::predict;
use trunnion_machine::Errors;

/// All effects of a model on one experiment.
pub(crate) struct SideBySide {
    pub effects: Vec<Placed>,
    /// Parameters of all effects, side by side.
    pub parameters: Vec<Parameter>,
    /// Index of the effect of each parameter.
    pub effect_of: Vec<usize>,
    /// Value at which the model holds a parameter, inside units.
    pub held: Vec<Option<f64>>,
    /// What the model expects of parameters beforehand.
    pub priors: Vec<Expected>,
}

/// A value expected beforehand, inside units.
pub(crate) struct Expected {
    pub parameter: usize,
    pub value: f64,
    pub u: f64,
}

/// One effect with its shape numbers.
pub(crate) struct Placed {
    pub id: String,
    pub instance: Instance,
    pub shapes: Shapes,
    pub shape: Vec<f64>,
    /// True when the model leaves the shape to the fit.
    pub shape_is_free: bool,
}

impl SideBySide {
    pub fn place(experiment: &Experiment, model: &Model) -> Result<Self, IdentifyError> {
        let mut joint =
            Self { effects: vec![], parameters: vec![], effect_of: vec![], held: vec![], priors: vec![] };
        for entry in &model.effects {
            if joint.effects.iter().any(|placed| placed.id == entry.id) {
                return Err(IdentifyError::EffectTwice { effect: entry.id.clone() });
            }
            let placed = place(experiment, entry)?;
            let parameters = placed.instance.parameters(&experiment.scene);
            if parameters.is_empty() {
                return Err(IdentifyError::out_of_reach(&placed.instance, &experiment.scene));
            }
            for (name, prior) in &entry.prior {
                let j = index(entry, &parameters, name)?;
                let per_inside = parameters[j].unit.per_inside;
                let (value, u) = (prior.value / per_inside, prior.u / per_inside);
                joint.priors.push(Expected { parameter: joint.width() + j, value, u });
            }
            joint.held.extend(held(entry, &parameters)?);
            joint.effect_of.extend(parameters.iter().map(|_| joint.effects.len()));
            joint.parameters.extend(parameters);
            joint.effects.push(placed);
        }
        Ok(joint)
    }

    pub fn width(&self) -> usize {
        self.parameters.len()
    }

    /// True for a column of an effect that was added to location errors and settings.
    pub fn is_added(&self, j: usize) -> bool {
        !matches!(self.effects[self.effect_of[j]].instance.role(), Role::Location | Role::Setting)
    }

    /// Columns that the data may determine.
    pub fn free(&self) -> Vec<usize> {
        (0..self.width()).filter(|&j| self.held[j].is_none()).collect()
    }

    /// The same, location errors and settings apart from what was added to them.
    pub fn free_by_role(&self) -> Free {
        let (added, base): (Vec<usize>, Vec<usize>) =
            self.free().into_iter().partition(|&j| self.is_added(j));
        let is_setting = |j: &usize| self.effects[self.effect_of[*j]].instance.role() == Role::Setting;
        let settings = base.iter().copied().filter(is_setting).collect();
        Free { base, settings, added }
    }

    /// All columns in the rows of `points`, mm per unit.
    pub fn columns(&self, experiment: &Experiment, points: Range<usize>) -> DMatrix<f64> {
        self.columns_at(experiment, &|i| Cow::Borrowed(&experiment.points[i].state), points)
    }

    /// The same with the points in other states.
    pub fn columns_at<'s>(
        &self,
        experiment: &Experiment,
        state_of: &dyn Fn(usize) -> Cow<'s, State>,
        points: Range<usize>,
    ) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(experiment.rows_of_points(&points).len(), self.width());
        let effects: Vec<(&Instance, &[f64])> =
            self.effects.iter().map(|placed| (&placed.instance, placed.shape.as_slice())).collect();
        experiment.add_columns_at(state_of, &effects, points, &mut columns);
        columns
    }

    /// Exact reading of every point, mm: all effects at once through the full transforms.
    pub fn predict_mm(&self, experiment: &Experiment, solution: &DVector<f64>) -> DVector<f64> {
        let first = self.first_parameters(experiment);
        let mut predicted = DVector::zeros(experiment.rows());
        for (i, point) in experiment.points.iter().enumerate() {
            let reading = self.reading_mm(experiment, &first, solution, &point.state);
            for (component, row) in experiment.rows_of(i).enumerate() {
                predicted[row] = reading[component];
            }
        }
        predicted
    }

    /// Number of the first parameter of each effect.
    fn first_parameters(&self, experiment: &Experiment) -> Vec<usize> {
        let counts = self.effects.iter().map(|placed| placed.instance.parameters(&experiment.scene).len());
        counts.scan(0, |sum, count| Some(std::mem::replace(sum, *sum + count))).collect()
    }

    /// Exact reading in one state, mm; `first` the first parameter of each effect.
    fn reading_mm(
        &self,
        experiment: &Experiment,
        first: &[usize],
        solution: &DVector<f64>,
        state: &State,
    ) -> Vector3<f64> {
        let mut errors = Errors::default();
        for (placed, first) in self.effects.iter().zip(first) {
            placed.instance.motions(
                &experiment.scene,
                &placed.shape,
                state,
                &mut |parameter, site, twist| {
                    errors.add(site, twist * solution[first + parameter]);
                },
            );
        }
        predict(experiment.machine(), &experiment.setups[state.setup], state, &errors)
    }
}

/// Exact readings of a fit in states that may be none of its points, mm; components that an instrument has not are zero. Settings are those of the
/// fit: ball and instrument as they were mounted.
///
/// # Errors
/// A model that is not that of the fit.
pub fn readings_at(
    experiment: &Experiment,
    model: &Model,
    fit: &Identification,
    states: &[State],
) -> Result<Vec<Vector3<f64>>, IdentifyError> {
    let mut joint = SideBySide::place(experiment, model)?;
    for (placed, fitted) in joint.effects.iter_mut().zip(&fit.effects) {
        placed.shape.clone_from(&fitted.shape);
    }
    let first = joint.first_parameters(experiment);
    Ok(states.iter().map(|state| joint.reading_mm(experiment, &first, &fit.solution, state)).collect())
}

fn place(experiment: &Experiment, entry: &ModelEffect) -> Result<Placed, IdentifyError> {
    let instance = Instance::from_model_effect(entry, experiment.machine())?;
    let shapes = instance.shapes(&experiment.scene);
    if !entry.shape.is_empty() && entry.shape.len() != shapes.names.len() {
        return Err(IdentifyError::WrongShape {
            effect: entry.id.clone(),
            expected: shapes.names.len(),
            names: shapes.names.join(", "),
            found: entry.shape.len(),
        });
    }
    let shape_is_free = entry.shape.is_empty() && !shapes.names.is_empty();
    let middle = shapes.grid.get(shapes.grid.len() / 2).cloned().unwrap_or_default();
    let shape = if shape_is_free { middle } else { entry.shape.clone() };
    Ok(Placed { id: entry.id.clone(), instance, shapes, shape, shape_is_free })
}

fn held(entry: &ModelEffect, parameters: &[Parameter]) -> Result<Vec<Option<f64>>, IdentifyError> {
    let mut held = vec![None; parameters.len()];
    for (name, value) in &entry.fixed {
        let j = index(entry, parameters, name)?;
        held[j] = Some(value / parameters[j].unit.per_inside);
    }
    Ok(held)
}

fn index(entry: &ModelEffect, parameters: &[Parameter], name: &str) -> Result<usize, IdentifyError> {
    parameters.iter().position(|p| p.name == name).ok_or_else(|| IdentifyError::UnknownParameter {
        effect: entry.id.clone(),
        name: name.into(),
        allowed: parameters.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", "),
    })
}
