//! Points, a model, and the one fit of it from which every answer starts.
//!
//! Weights, outliers, folds, repeatability and covariance are those of this fit. Who adds an effect takes [`Problem::with`]: the
//! same fit of the larger model. So a candidate of a diagnosis, a trial and a row of the ladder show the same figures.

pub mod design;
pub mod experiment;
pub(crate) mod folds;
pub(crate) mod joint;
pub mod passes;
pub(crate) mod sequence;
pub(crate) mod stream;

use crate::fit::identification::Identification;
use crate::fit::identify;
use crate::fit::options::{IdentifyError, Options};
use crate::problem::experiment::Experiment;
use trunnion_effects::{Model, ModelEffect};

/// Points and a model, fitted.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    experiment: &'a Experiment,
    model: Model,
    fit: Identification,
}

impl<'a> Problem<'a> {
    /// Fits a model to an experiment with the default options.
    ///
    /// # Errors
    /// As [`identify`].
    pub fn new(experiment: &'a Experiment, model: &Model) -> Result<Self, IdentifyError> {
        let fit = identify(experiment, model, &Options::default())?;
        Ok(Self { experiment, model: model.clone(), fit })
    }

    /// The same points with more effects at the end of the model.
    ///
    /// # Errors
    /// As [`identify`].
    pub fn with(&self, added: &[ModelEffect]) -> Result<Self, IdentifyError> {
        let mut model = self.model.clone();
        model.effects.extend_from_slice(added);
        Self::new(self.experiment, &model)
    }

    /// The points.
    pub fn experiment(&self) -> &'a Experiment {
        self.experiment
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The fit.
    pub fn fit(&self) -> &Identification {
        &self.fit
    }
}
