//! What the signs of fitted values say of the machine: only weight knows where down is, so that readings with every sign reversed, which fit
//! as well, say what a person can see to be wrong.

use crate::fit::identification::Identification;
use crate::problem::Problem;
use trunnion_effects::{Instance, Scene};

/// A value so many of its standard uncertainties from zero has a sign: one in 700 has the wrong one by chance [normal distribution].
const SURE: f64 = 3.0;

/// What a parameter of `instance` says by its sign in this fit.
pub fn meaning_of_sign(fit: &Identification, instance: &Instance, scene: &Scene) -> Option<String> {
    let id = instance.id();
    instance.parameters(scene).into_iter().find_map(|parameter| {
        let own = fit.parameters.iter().find(|p| p.effect == id && p.name == parameter.name)?;
        let (value, u) = own.value.zip(own.u)?;
        parameter.said_by_sign(&id, value).filter(|_| value.abs() > SURE * u)
    })
}

/// The same of the model that was fitted: what a person added says it still.
pub fn of_model(problem: &Problem<'_>) -> Option<String> {
    let experiment = problem.experiment();
    // The fit was made of these entries.
    let instance = |entry| Instance::from_model_effect(entry, experiment.machine()).ok();
    let mut instances = problem.model().effects.iter().filter_map(instance);
    instances.find_map(|instance| meaning_of_sign(problem.fit(), &instance, &experiment.scene))
}
