//! A model fitted to runs.

use crate::analysis::diagnosed;
use crate::{Error, Experiment, Model};
use std::sync::{Arc, OnceLock};
use trunnion_effects as effects;
use trunnion_effects::Instance;
use trunnion_effects::catalogue::BASE;
use trunnion_engine::{BetweenRuns, Identification, IdentifyError, Problem, doubts, next_cycle};
use trunnion_results as results;
use trunnion_results::number::finite;
use trunnion_results::sentences::not_plausible;

/// A model fitted to runs. Clones share the data.
#[derive(Clone)]
pub struct Fit {
    experiment: Experiment,
    model: Arc<Model>,
    identification: Arc<Identification>,
    /// What differs between the runs, once somebody asks.
    pub(crate) between: Arc<OnceLock<Vec<Option<BetweenRuns>>>>,
}

impl Experiment {
    /// Fits every effect of a model to the runs together.
    ///
    /// # Errors
    /// A model that does not suit machine or runs, or a fit that does not converge.
    pub fn fit(&self, model: &Model) -> Result<Fit, Error> {
        self.fit_as(model.clone(), model)
    }

    /// Fits a model whose entries stand in the file of another.
    fn fit_as(&self, model: Model, in_file: &Model) -> Result<Fit, Error> {
        let fitted = Problem::known(self.points(), model.entries(), self);
        let fitted = fitted.map_err(|error| self.with_doubt(error, in_file))?.into_fit();
        Ok(Fit::of(self, model, fitted))
    }

    /// A model that cannot be placed says where in its file, and a fit that does not converge what is wrong with the runs, where that is known.
    fn with_doubt(&self, error: IdentifyError, in_file: &Model) -> Error {
        if let Err(problems) = in_file.suits(self.machine()) {
            return problems;
        }
        let implausible = match error {
            IdentifyError::NotConverged { .. } => self.plausibility(),
            _ => Vec::new(),
        };
        match implausible.is_empty() {
            true => error.into(),
            false => Error::NotPlausible { doubt: not_plausible(&implausible), source: error.into() },
        }
    }

    /// The same without the effects that these runs cannot show.
    ///
    /// # Errors
    /// As [`Experiment::fit`].
    pub fn fit_within_reach(&self, model: &Model) -> Result<Fit, Error> {
        self.fit_as(self.within_reach(model).into(), model)
    }

    /// The effects of the model that these runs can show, and those that every model has.
    pub(crate) fn within_reach(&self, model: &Model) -> effects::Model {
        let mut reachable = model.entries().clone();
        reachable.effects.retain(|entry| {
            let instance = Instance::from_model_effect(entry, self.machine());
            // What the machine cannot have is refused by the fit, and not left out without a message.
            let out_of_reach = instance.is_ok_and(|of| of.parameters(&self.points().scene).is_empty());
            BASE.contains(&entry.id.as_str()) || !out_of_reach
        });
        reachable
    }
}

impl Fit {
    pub(crate) fn of(experiment: &Experiment, model: Model, identification: Identification) -> Self {
        Self {
            experiment: experiment.clone(),
            model: Arc::new(model),
            identification: Arc::new(identification),
            between: Arc::default(),
        }
    }

    /// The same fit of a model that differs in what it keeps and remembers alone.
    pub(crate) fn with_model(self, model: Model) -> Self {
        Self { model: Arc::new(model), ..self }
    }

    /// The runs.
    pub fn experiment(&self) -> &Experiment {
        &self.experiment
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The fit as the engine gives it.
    pub fn identification(&self) -> &Identification {
        &self.identification
    }

    /// The fit as a problem of the engine, for what starts from it.
    pub(crate) fn problem(&self) -> Problem<'_> {
        let problem = Problem::of_fit(self.experiment.points(), self.model.entries(), self.identification());
        problem.knowing(&self.experiment)
    }

    /// The fit in `trunnion-identification/1`; [`Self::identified`] is the whole answer.
    pub fn results(&self) -> results::Identification {
        let fit = self.identification();
        let mut answer = results::Identification {
            complete: self.complete(),
            plausibility: self.experiment.plausibility(),
            doubts: self.doubts(),
            ..fit.into()
        };
        for ((shown, fitted), between) in
            answer.parameters.iter_mut().zip(&fit.parameters).zip(self.between_runs())
        {
            let (Some(u), Some(between)) = (fitted.u, between) else { continue };
            let u = between.u_of_mean(u);
            shown.u = finite(u * fitted.unit.per_inside);
            shown.u_another_run = finite(u.hypot(between.sd) * fitted.unit.per_inside);
        }
        answer
    }

    /// Its numbers to doubt.
    pub(crate) fn doubts(&self) -> Vec<results::Doubt> {
        let found = doubts(self.experiment.points(), self.model.entries(), self.identification());
        let of_readings = self.experiment.doubts().into_iter();
        let of_model = self.model.doubt_for(&self.experiment.machine().name);
        of_readings.chain(of_model).chain(found.iter().map(results::Doubt::from)).collect()
    }

    /// Measured against predicted, point by point.
    pub fn residuals(&self) -> results::Residuals {
        results::Comparison::new(self.experiment.points(), self.identification(), None).residuals
    }

    /// What is planned, read, missing, and excluded by the fit too.
    pub(crate) fn complete(&self) -> results::Complete {
        self.experiment.complete().with_outliers(self.identification().outliers.len())
    }

    /// The answer of `trunnion identify`: with how well the runs are known in time, for which their sweeps are looked at.
    pub fn identified(&self) -> results::Identification {
        results::Identification { time_quality: self.experiment.time_quality(), ..self.results() }
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::identification_text(&self.results())
    }

    /// Where the model fails most, worst first; empty when no place stands out of the noise.
    pub fn places(&self) -> Vec<results::Place> {
        let fit = self.identification();
        trunnion_engine::compare::places(self.experiment.points(), &fit.residual_mm, &fit.used)
    }

    /// The cycle that separates these effects; without any, what the diagnosis says to measure next. `None` when it leaves nothing open.
    ///
    /// # Errors
    /// Effects that this machine cannot have, or that the model holds already.
    pub fn plan(&self, rivals: &[String]) -> Result<Option<results::Plan>, Error> {
        let (problem, options) = (self.problem(), next_cycle::Options::default());
        let plan = if rivals.is_empty() {
            next_cycle::next(&problem, &diagnosed(self.experiment(), &problem)?, &options)?
        } else {
            let rivals = next_cycle::rivals_named(rivals, self.experiment.machine())
                .map_err(next_cycle::PlanError::from)?;
            Some(next_cycle::plan_problem(&problem, &rivals, &options)?)
        };
        Ok(plan.as_ref().map(results::Plan::from))
    }
}
