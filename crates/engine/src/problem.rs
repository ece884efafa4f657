//! Points, a model, and the one fit of it from which every answer starts.
//!
//! Weights, outliers, folds, repeatability and covariance are those of this fit. Who adds an effect takes [`Problem::with`]: the
//! same fit of the larger model. So a candidate of a diagnosis, a trial and a row of the ladder show the same figures.

pub(crate) mod credible;
pub mod design;
pub mod experiment;
pub(crate) mod folds;
pub mod known;
pub(crate) mod last_run;
pub(crate) mod off_nominal;
pub(crate) mod one_way;
pub mod passes;
pub(crate) mod poses;
pub(crate) mod rows;
pub mod runs;
pub(crate) mod sequence;
pub(crate) mod side_by_side;
pub(crate) mod steps;
pub(crate) mod stream;
pub(crate) mod taken;

use crate::fit::errors::Errors;
use crate::fit::identification::Identification;
use crate::fit::identify_sharing;
use crate::fit::options::{IdentifyError, Options, Uncertainties};
use crate::fit::reading_noise::ReadingNoise;
use crate::noise::learned::remainder::weighted;
use crate::problem::experiment::Experiment;
use crate::problem::known::KnownFits;
use crate::problem::rows::Rows;
use credible::credible_columns;
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use trunnion_effects::{Instance, Model, ModelEffect};

/// Points and a model, fitted.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    experiment: &'a Experiment,
    model: Cow<'a, Model>,
    fit: Cow<'a, Identification>,
    known: Option<&'a dyn KnownFits>,
}

impl<'a> Problem<'a> {
    /// Fits a model to an experiment with the default options.
    ///
    /// # Errors
    /// As [`crate::identify`].
    pub fn new(experiment: &'a Experiment, model: &Model) -> Result<Self, IdentifyError> {
        Self::of_model(experiment, model.clone(), None, None)
    }

    /// A fit that was made before, by [`Problem::new`] or with its options, of this model to this experiment.
    pub fn of_fit(experiment: &'a Experiment, model: &'a Model, fit: &'a Identification) -> Self {
        Self { experiment, model: Cow::Borrowed(model), fit: Cow::Borrowed(fit), known: None }
    }

    /// Fits a model as [`Problem::new`], unless its fit is known; so are all that come from it.
    ///
    /// # Errors
    /// As [`crate::identify`].
    pub fn known(
        experiment: &'a Experiment,
        model: &Model,
        known: &'a dyn KnownFits,
    ) -> Result<Self, IdentifyError> {
        Self::of_model(experiment, model.clone(), None, Some(known))
    }

    /// The same problem; what comes from it is looked up with `known` first.
    #[must_use]
    pub fn knowing(self, known: &'a dyn KnownFits) -> Self {
        Self { known: Some(known), ..self }
    }

    /// `other`: another fit of the same points.
    fn of_model(
        experiment: &'a Experiment,
        model: Model,
        other: Option<&Identification>,
        known: Option<&'a dyn KnownFits>,
    ) -> Result<Self, IdentifyError> {
        let fit = match known.and_then(|known| known.fit(&model)) {
            Some(fit) => fit,
            None => {
                let fit = identify_sharing(experiment, &model, &Options::default(), other)?;
                if let Some(known) = known {
                    known.made(&model, &fit);
                }
                fit
            }
        };
        Ok(Self { experiment, model: Cow::Owned(model), fit: Cow::Owned(fit), known })
    }

    /// The same points with more effects at the end of the model.
    ///
    /// # Errors
    /// As [`crate::identify`].
    pub fn with(&self, added: &[ModelEffect]) -> Result<Self, IdentifyError> {
        Self::of_model(self.experiment, self.larger(added), Some(&self.fit), self.known)
    }

    /// The errors of [`Problem::with`]: without its uncertainties, which take most of the time.
    pub(crate) fn errors_with(&self, added: &[ModelEffect]) -> Result<Errors, IdentifyError> {
        let model = self.larger(added);
        let known = self.known.and_then(|known| known.fit(&model));
        let options = Options { uncertainties: Uncertainties::Clusters, ..Options::default() };
        let made = || identify_sharing(self.experiment, &model, &options, Some(&self.fit));
        Ok(known.map_or_else(made, Ok)?.errors())
    }

    /// The model with more effects at its end.
    fn larger(&self, added: &[ModelEffect]) -> Model {
        let mut model = self.model().clone();
        model.effects.extend_from_slice(added);
        model
    }

    /// Columns of the free parameters of the model at the shapes fitted, of points of the same scene; rows × columns, mm per inside unit.
    ///
    /// # Errors
    /// The model has an effect that the machine cannot have.
    pub fn columns(&self, experiment: &Experiment) -> Result<DMatrix<f64>, IdentifyError> {
        let mut all = DMatrix::zeros(experiment.rows(), 0);
        for (entry, fitted) in self.model.effects.iter().zip(&self.fit.effects) {
            let instance = Instance::from_model_effect(entry, experiment.machine())?;
            let columns = credible_columns(experiment, &instance, &fitted.shape);
            let parameters = instance.parameters(&experiment.scene);
            let is_free = |j: &usize| entry.fixed.iter().all(|(name, _)| *name != parameters[*j].name);
            let free: Vec<usize> = (0..parameters.len()).filter(is_free).collect();
            let first = all.ncols();
            all = all.resize_horizontally(first + free.len(), 0.0);
            all.columns_mut(first, free.len()).copy_from(&columns.select_columns(&free));
        }
        Ok(all)
    }

    /// The same on the rows that are looked at, weighted.
    pub(crate) fn columns_on(
        &self,
        rows: &Rows<'_>,
        root: &DVector<f64>,
    ) -> Result<DMatrix<f64>, IdentifyError> {
        Ok(weighted(rows.of(self.columns(self.experiment)?), root))
    }

    /// The noise of the readings next to this fit; `None` where they are too few, or of several ways of measuring, to say what is noise.
    ///
    /// # Errors
    /// The model has an effect that the machine cannot have.
    pub fn reading_noise(&self) -> Result<Option<ReadingNoise<'a>>, IdentifyError> {
        let fit = self.fit();
        let columns = |rows: &Rows<'_>, root: &DVector<f64>| self.columns_on(rows, root);
        ReadingNoise::learn(self.experiment, &fit.fitted(), fit.degrees_of_freedom, columns)
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

    /// The fit alone.
    pub fn into_fit(self) -> Identification {
        self.fit.into_owned()
    }
}
