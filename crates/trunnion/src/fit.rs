//! A model fitted to runs, and everything that can be asked of it.

use crate::analysis::FormulaText;
use crate::{Compared, Diagnosed, Error, Experiment, Model, Step, Trial, analysis, prediction};
use std::sync::Arc;
use trunnion_engine::{Identification, diagnosis, fit, next_cycle};
use trunnion_results as results;

/// A model fitted to runs. Clones share the data.
#[derive(Clone)]
pub struct Fit {
    experiment: Experiment,
    model: Arc<Model>,
    identification: Arc<Identification>,
}

impl Fit {
    pub(crate) fn new(experiment: &Experiment, model: &Model) -> Result<Self, Error> {
        let fitted =
            trunnion_engine::identify(experiment.points(), model.entries(), &fit::Options::default())?;
        Ok(Self::of(experiment, model.clone(), fitted))
    }

    pub(crate) fn of(experiment: &Experiment, model: Model, identification: Identification) -> Self {
        Self {
            experiment: experiment.clone(),
            model: Arc::new(model),
            identification: Arc::new(identification),
        }
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

    /// The answer: `trunnion-identification/1`.
    pub fn results(&self) -> results::Identification {
        self.identification().into()
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::identification_text(&self.results())
    }

    /// Which effect the model lacks; where candidates are confused, the cycle that separates them is planned too.
    ///
    /// # Errors
    /// Too few readings to judge the model.
    pub fn diagnose(&self) -> Result<Diagnosed, Error> {
        let diagnosis = analysis::diagnose_and_plan(self.experiment.points(), self.model.entries())?;
        Ok(Diagnosed::of(self, diagnosis))
    }

    /// Adds an effect to the model and fits again. A `formula:NAME` takes the expression that the diagnosis proposes.
    ///
    /// # Errors
    /// An unknown effect or one that is in the model already, or a fit that fails.
    pub fn add(&self, effect: &str) -> Result<Step, Error> {
        self.add_as(effect, &FormulaText::default())
    }

    /// The same with what a user says of the expression of a formula. An effect that was written into the model file by hand, and
    /// has no ladder row yet, gets its row.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn add_as(&self, effect: &str, told: &FormulaText) -> Result<Step, Error> {
        Step::of(self, effect, told)
    }

    /// Takes an effect out of the model, fits again and measures the ladder rows after it again; `date` goes into them.
    ///
    /// # Errors
    /// An effect that is not in the model, or is in every model.
    pub fn remove(&self, effect: &str, date: &str) -> Result<Self, Error> {
        let points = self.experiment.points();
        let smaller = analysis::remove(points, self.model.entries(), effect, date)?;
        let mut model = self.model.without(effect)?;
        for entry in &smaller.effects {
            let old = self.model.entries().effects.iter().find(|old| old.id == entry.id);
            if let Some(row) =
                entry.ladder.as_ref().filter(|_| old.is_none_or(|old| old.ladder != entry.ladder))
            {
                model = model.with_ladder_row(&entry.id, row)?;
            }
        }
        Self::new(&self.experiment, &model)
    }

    /// Predicts other runs with the values of this fit: everything of the machine frozen, only how the ball was set in the new
    /// runs is fitted.
    ///
    /// # Errors
    /// Runs of another machine, or runs that an effect of the model is out of reach of.
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        prediction::predict(self, other)
    }

    /// Where the model fails, with what is missing from it.
    ///
    /// # Errors
    /// When the diagnosis fails.
    pub fn compare(&self) -> Result<Compared, Error> {
        Compared::of(self)
    }

    /// What one more effect would do; the model stays as it is. `told` is what a user says of the expression of a formula.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn try_effect(&self, effect: &str, told: &FormulaText) -> Result<Trial, Error> {
        Trial::of(self, effect, told)
    }

    /// The cycle that separates these effects; without any, those that the diagnosis leaves open. `None` when it leaves none open.
    ///
    /// # Errors
    /// Effects that this machine cannot have, or that the model holds already.
    pub fn plan(&self, rivals: &[String]) -> Result<Option<next_cycle::Plan>, Error> {
        let (points, model) = (self.experiment.points(), self.model.entries());
        let rivals = if rivals.is_empty() {
            next_cycle::wanted(&trunnion_engine::diagnose(points, model, &diagnosis::Options::default())?)
        } else {
            next_cycle::rivals_named(rivals, self.experiment.machine())
                .map_err(next_cycle::PlanError::from)?
        };
        if matches!(&rivals, next_cycle::Rivals::Reveal(effects) if effects.is_empty()) {
            return Ok(None);
        }
        Ok(Some(next_cycle::plan(points, model, &rivals, &next_cycle::Options::default())?))
    }
}
