//! What to measure next: the cycle that separates rival effects, per minute of machine time (docs/design/statistics.md §6).
//!
//! Rivals are effects that the data cannot tell apart, or that the present cycle cannot see at all. Candidate cycles are made
//! from the machine and the present setups (`candidates`); for each the states it visits, the columns of rivals and model there
//! together with the present data (same location errors, ball mounted again), whitened under a few noise models (`information`),
//! and from these the expected ln Bayes factor of every two rivals: T-optimality (`separation`). Cycles that tell every pair
//! apart come first, then those that tell the first rival from most others, then those that separate the pairs farthest on
//! average, per minute.
//! Limits: linear in small errors; the noise stays what it is; nothing is charged for the number of parameters.

mod advice;
mod answer;
mod candidates;
mod consideration;
mod design;
mod information;
mod knowledge;
mod present;
mod preview;
mod rivals;
mod separation;
mod utility;

pub use advice::{PlannedCycle, advise};
pub use answer::{Considered, LeftOpen, Plan};
pub use preview::{Alias, Preview, preview};
pub use rivals::{Rivals, rivals_named, wanted};

use crate::problem::Problem;
use crate::{Experiment, ExperimentError, IdentifyError};
use candidates::candidates;
use design::CycleDesign;
use information::Part;
use present::Present;
use trunnion_cycles::{Pace, VisitError};
use trunnion_effects::{Instance, Model, ModelEffect, UnknownEffect};

/// What a plan may assume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How fast the machine goes about a cycle.
    pub pace: Pace,
    /// ln of the Bayes factor that counts as separated.
    pub separated_ln: f64,
    /// Points of each run that take part; more are thinned evenly.
    pub most_points: usize,
}

impl Default for Options {
    /// A factor of a thousand separates.
    fn default() -> Self {
        Self { pace: Pace::default(), separated_ln: 1000f64.ln(), most_points: 600 }
    }
}

/// Beyond this ln of the Bayes factor more is of no use.
const ENOUGH_LN: f64 = 20.0;
/// Below this ln no cycle is worth its time.
const HOPELESS_LN: f64 = 3.0;
/// Shapes of a rival that may imitate another one.
const MOST_SHAPES: usize = 12;
/// The same where many effects are compared.
const FEW_SHAPES: usize = 3;

/// Why a plan was not possible.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The model does not fit the data.
    #[error("the model cannot be fitted to the present runs")]
    Fit(#[from] IdentifyError),
    /// An effect this machine cannot have.
    #[error("a rival cannot be placed on this machine")]
    Rival(#[from] UnknownEffect),
    /// Runs and next cycle do not go together.
    #[error("the next cycle cannot be put together with the present runs")]
    Experiment(#[from] ExperimentError),
    /// A cycle the machine cannot run.
    #[error("the cycle cannot be run")]
    Visit(#[from] VisitError),
    /// The model holds one of the rivals already.
    #[error("the model holds {effect} already, so nothing is left to tell from it; name effects it lacks")]
    InModel {
        /// Effect id.
        effect: String,
    },
    /// Fewer than two.
    #[error("nothing to compare; name two or more effects with --rivals")]
    NoRivals,
}

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
    for candidate in candidates(machine, present.last_setups(), &states, &options.pace) {
        considered.extend(design.consider(&candidate, &knowledge, options)?);
    }
    Ok(answer::answer(&design, &before, considered, options))
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
