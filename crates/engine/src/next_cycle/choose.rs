//! The choice of the next cycle.

use super::answer::{Plan, answer};
use super::candidates::candidates;
use super::design::CycleDesign;
use super::information::Part;
use super::options::{ENOUGH_LN, Options, PlanError};
use super::present::Present;
use super::rivals::Rivals;
use crate::Experiment;
use crate::evidence::parallel;
use crate::problem::Problem;
use trunnion_effects::{Instance, Model, ModelEffect, UnknownEffect};

/// Shapes of a rival that may imitate another one.
const MOST_SHAPES: usize = 12;
/// The same where many effects are compared.
const FEW_SHAPES: usize = 3;

/// Chooses the next cycle.
///
/// # Errors
/// A model or rival that does not fit machine or data.
pub fn plan(
    experiment: &Experiment,
    model: &Model,
    rivals: &Rivals,
    options: &Options,
) -> Result<Plan, PlanError> {
    plan_problem(&Problem::new(experiment, model)?, rivals, options)
}

/// The same for a model that is fitted already.
///
/// # Errors
/// As [`plan`].
pub fn plan_problem(problem: &Problem<'_>, rivals: &Rivals, options: &Options) -> Result<Plan, PlanError> {
    let (experiment, model) = (problem.experiment(), problem.model());
    let entries = rivals.entries();
    if let Some(entry) = entries.iter().find(|entry| model.effects.iter().any(|own| own.id == entry.id)) {
        return Err(PlanError::InModel { effect: entry.id.clone() });
    }
    if entries.is_empty() || (matches!(rivals, Rivals::Separate(_)) && entries.len() < 2) {
        return Err(PlanError::NoRivals);
    }
    let machine = experiment.machine();
    let instances: Vec<Instance> = entries
        .iter()
        .map(|entry| Instance::from_model_effect(entry, machine))
        .collect::<Result<_, UnknownEffect>>()?;
    let present = Present::new(problem, options.most_points)?;
    let (entries, instances) = credible(&present.experiment, rivals, entries, instances);
    let (entries, instances) = (&entries[..], instances);
    let most_shapes = if entries.len() > 4 { FEW_SHAPES } else { MOST_SHAPES };
    let separated_ln = options.separated_ln.min(ENOUGH_LN);
    let design =
        CycleDesign { present: &present, entries, instances: &instances, rivals, most_shapes, separated_ln };
    let knowledge = design.knowledge();
    let before = design.utility(&present.experiment, &knowledge);

    let again = design.again(&knowledge, options)?;
    let states = present.last_states();
    let mut considered = vec![again];
    let candidates = candidates(machine, present.last_setups(), &states, &options.pace);
    let each = parallel(candidates.len(), |i| design.consider(&candidates[i], &knowledge, options));
    for candidate in each {
        considered.extend(candidate?);
    }
    Ok(answer(&design, &before, considered, options))
}

/// Without the rivals that move nothing in the present data at any credible size: they explain nothing there.
fn credible(
    present: &Experiment,
    rivals: &Rivals,
    entries: &[ModelEffect],
    instances: Vec<Instance>,
) -> (Vec<ModelEffect>, Vec<Instance>) {
    let moves = |instance: &Instance| {
        let shapes = instance.shapes(&present.scene).grid;
        let shape = shapes.into_iter().next().unwrap_or_default();
        let columns = Part { instance, shape }.columns(present);
        columns.is_empty() || columns.amax() > 0.0
    };
    let all = || entries.iter().cloned().zip(instances.iter().cloned());
    let kept: Vec<_> = all().filter(|(_, instance)| moves(instance)).collect();
    match rivals {
        Rivals::Separate(_) if kept.len() > 1 => kept.into_iter().unzip(),
        _ => all().unzip(),
    }
}

#[cfg(test)]
mod tests;
