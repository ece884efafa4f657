//! What additions do to the error: the fits of the model with each of them, as adding it makes them.

use crate::Experiment;
use crate::diagnosis::verdict::CandidateParameter;
use crate::evidence::parallel;
use crate::fit::doubts::{Doubt, doubts_of, no_lag};
use crate::fit::errors::Errors;
use crate::fit::identification::Identification;
use crate::fit::options::IdentifyError;
use crate::problem::Problem;
use crate::solve::combinations::Combination;
use trunnion_core::chain;
use trunnion_core::convert::um_from_mm;
use trunnion_core::number::um;
use trunnion_effects::catalogue::effect_name;
use trunnion_effects::{Instance, ModelEffect, Scene, Unit};

/// A fit of the model with something added.
pub struct Refit {
    added: Vec<ModelEffect>,
    fit: Identification,
}

/// An addition with which the model cannot be fitted, so that it cannot be added either.
pub struct Unfitted {
    added: Vec<ModelEffect>,
    error: Box<IdentifyError>,
}

impl Unfitted {
    /// Whether all of it is among these.
    pub fn is_among(&self, ids: &[String]) -> bool {
        self.added.iter().all(|entry| ids.contains(&entry.id))
    }

    /// Whether it is this effect alone.
    pub fn is_of(&self, id: &str) -> bool {
        matches!(&self.added[..], [only] if only.id == id)
    }

    /// What cannot be fitted, and why.
    pub fn words(&self) -> String {
        let ids: Vec<&str> = self.added.iter().map(|entry| entry.id.as_str()).collect();
        format!(
            "The model with {} cannot be fitted to these readings: {}.",
            ids.join(", "),
            chain(self.error.as_ref())
        )
    }
}

/// Fits the model with each of the additions, in their order.
pub fn refits(problem: &Problem<'_>, additions: Vec<Vec<ModelEffect>>) -> Vec<Result<Refit, Unfitted>> {
    // All that was found stands last and takes longest: last of two threads it would work alone.
    let last_first = |i: usize| &additions[additions.len() - 1 - i];
    let mut fits = parallel(additions.len(), |i| problem.with(last_first(i)).map(Problem::into_fit));
    fits.reverse();
    let with = |(added, fit)| match fit {
        Ok(fit) => Ok(Refit { added, fit }),
        Err(error) => Err(Unfitted { added, error: Box::new(error) }),
    };
    additions.into_iter().zip(fits).map(with).collect()
}

/// The errors of the model with each of the additions, in their order; `None` where it cannot be fitted.
pub fn errors(problem: &Problem<'_>, additions: &[Vec<ModelEffect>]) -> Vec<Option<Errors>> {
    parallel(additions.len(), |i| problem.errors_with(&additions[i]).ok())
}

/// Shares of the mean square that the additions explain together.
pub struct Explained {
    /// Root mean square of what the model leaves.
    pub before_mm: f64,
    /// The same with everything that was found.
    pub least_mm: f64,
}

impl Explained {
    /// Share of what is explained together that is explained where `after_mm` is left, 0…1.
    pub fn by(&self, after_mm: f64) -> f64 {
        let explainable = self.before_mm.powi(2) - self.least_mm.powi(2);
        if explainable <= 0.0 {
            return 0.0;
        }
        ((self.before_mm.powi(2) - after_mm.powi(2)) / explainable).clamp(0.0, 1.0)
    }

    /// Share of the mean square that all together leave, 0…1.
    pub fn by_nothing(&self) -> f64 {
        (self.least_mm / self.before_mm.max(f64::MIN_POSITIVE)).powi(2)
    }
}

impl Refit {
    pub fn fit(&self) -> &Identification {
        &self.fit
    }

    pub fn rms_mm(&self) -> f64 {
        self.fit.rms_mm
    }

    pub fn rms_um(&self) -> f64 {
        um_from_mm(self.fit.rms_mm)
    }

    pub fn errors(&self) -> Errors {
        self.fit.errors()
    }

    pub fn holdout_rms_um(&self) -> Option<f64> {
        self.fit.holdout_rms_mm().map(um_from_mm)
    }

    /// What to doubt in the numbers of one of the effects.
    pub fn doubts(&self, problem: &Problem<'_>, id: &str) -> Vec<Doubt> {
        let mut model = problem.model().clone();
        model.effects.extend(self.added.iter().cloned());
        let own = self.fit.effects.iter().find(|effect| effect.id == id);
        own.map_or_else(Vec::new, |effect| doubts_of(problem.experiment(), &model, &self.fit, effect))
    }

    /// Whether another cause may be behind one of the effects that were added.
    pub fn is_of_another_cause(&self, problem: &Problem<'_>) -> bool {
        let of_effect = |entry: &ModelEffect| self.doubts(problem, &entry.id);
        self.added.iter().flat_map(of_effect).any(|doubt| doubt.is_of_another_cause())
    }

    /// What its time constant says where it is none.
    pub fn no_lag(&self, experiment: &Experiment, id: &str) -> Option<String> {
        no_lag(experiment, self.fit.effects.iter().find(|effect| effect.id == id)?)
    }

    /// Effects that were added, with their shape numbers.
    pub fn shapes(&self) -> impl Iterator<Item = (&str, &[f64])> {
        let effects = self.fit.effects.iter().filter(|effect| self.is_new(&effect.id));
        effects.map(|effect| (effect.id.as_str(), effect.shape.as_slice()))
    }

    fn is_new(&self, id: &str) -> bool {
        self.added.iter().any(|entry| entry.id == id)
    }

    /// Why what was added cannot be the cause: the first parameter of `instance` that is larger than its cause allows, of the limits of one
    /// sort.
    pub fn beyond_physical(&self, instance: &Instance, scene: &Scene, resembles: bool) -> Option<String> {
        let id = instance.id();
        let fitted: Vec<_> =
            self.fit.parameters.iter().filter(|p| p.effect == id && p.stands_alone()).collect();
        instance.parameters(scene).into_iter().find_map(|parameter| {
            let limit = parameter.limit.filter(|limit| limit.resembles == resembles)?;
            let found = fitted.iter().find(|fitted| fitted.name == parameter.name)?;
            let value = found.screen_value()?;
            limit.is_exceeded(value).then(|| {
                format!(
                    "{} fits best, but with {} = {value:.0} {unit}, where {:.0} {unit} is the most that is physical: {}.",
                    effect_name(&id),
                    parameter.name,
                    limit.largest,
                    limit.beyond,
                    unit = parameter.unit.text(),
                )
            })
        })
    }

    /// Why a name stands for nothing in this fit: neither a parameter of it nor a combination of them has a value there, as the model imitates
    /// all of them.
    pub fn unseen(&self, instance: &Instance) -> Option<String> {
        let id = instance.id();
        let mut own = self.fit.parameters.iter().filter(|p| p.effect == id).peekable();
        let is_nothing = own.peek().is_some() && own.all(|p| p.value.is_none());
        (is_nothing && self.seen_together(&id).next().is_none()).then(|| {
            format!(
                "{} fits best, but the model with it determines none of its parameters: the positions of this cycle do not show it.",
                effect_name(&id)
            )
        })
    }

    /// Combinations of parameters of one effect that have a value although none of them has.
    pub fn seen_together<'f>(&'f self, id: &'f str) -> impl Iterator<Item = &'f Combination> {
        let is_own = move |j: &usize| self.fit.parameters[*j].effect == id;
        self.fit.seen_together.iter().filter(move |combination| combination.parameters.iter().all(is_own))
    }

    /// Why these readings cannot show what was added: a sudden change no larger than a step of the display is what the display makes of a
    /// slow one, which noise as small does not spread over several values.
    pub fn within_step(&self, instance: &Instance, scene: &Scene, step_mm: f64) -> Option<String> {
        let sudden: Vec<String> =
            instance.parameters(scene).into_iter().filter(|p| p.sudden).map(|p| p.name).collect();
        let id = instance.id();
        let of_change = self.fit.parameters.iter().filter(|p| p.effect == id && sudden.contains(&p.name));
        let squares: Vec<f64> = of_change.filter_map(|p| p.value).map(|mm| mm * mm).collect();
        let change_mm = squares.iter().sum::<f64>().sqrt();
        (!squares.is_empty() && change_mm <= step_mm).then(|| {
            format!(
                "{} fits best, but with {}, where the display has steps of {}: it shows a slow change of that size as \
                 a sudden one. Repeat with a finer display.",
                effect_name(&id),
                um(um_from_mm(change_mm)),
                um(um_from_mm(step_mm)),
            )
        })
    }

    /// Parameters of what was added, shape numbers last.
    pub fn parameters(&self) -> Vec<CandidateParameter> {
        let fitted =
            self.fit.parameters.iter().filter(|p| self.is_new(&p.effect)).map(|p| CandidateParameter {
                effect: p.effect.clone(),
                name: p.name.clone(),
                value: p.screen_value(),
                u: p.screen_u(),
                unit: p.unit.symbol.into(),
            });
        let effects = self.fit.effects.iter().filter(|effect| self.is_new(&effect.id));
        let shapes = effects.flat_map(|effect| {
            let numbers = effect.shape_names.iter().zip(&effect.shape).zip(self.fit.shape_u(effect));
            numbers.map(move |((name, value), u)| CandidateParameter {
                effect: effect.id.clone(),
                name: name.clone(),
                value: Some(*value),
                u,
                unit: Unit::in_name(name).symbol.into(),
            })
        });
        fitted.chain(shapes).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_fitted_is_named_with_the_reason() {
        let id = "formula:ball-dx".to_string();
        let entry = ModelEffect { id: id.clone(), ..ModelEffect::default() };
        let unfitted =
            Unfitted { added: vec![entry], error: Box::new(IdentifyError::EffectTwice { effect: id }) };
        assert_eq!(
            unfitted.words(),
            "The model with formula:ball-dx cannot be fitted to these readings: the model lists effect formula:ball-dx twice; keep one."
        );
    }
}
