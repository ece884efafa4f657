//! A fit together with its diagnosis.

use crate::{Error, Experiment, Fit, Step};
use std::sync::Arc;
use trunnion_engine::Diagnosis;
use trunnion_results as results;

/// A fit, and what its model lacks. Clones share the data.
#[derive(Clone)]
pub struct Diagnosed {
    fit: Fit,
    diagnosis: Arc<Diagnosis>,
}

impl Diagnosed {
    pub(crate) fn of(fit: &Fit, diagnosis: Diagnosis) -> Self {
        Self { fit: fit.clone(), diagnosis: Arc::new(diagnosis) }
    }

    /// The fit that was diagnosed.
    pub fn fit(&self) -> &Fit {
        &self.fit
    }

    /// The diagnosis as the engine gives it.
    pub fn diagnosis(&self) -> &Diagnosis {
        &self.diagnosis
    }

    /// The answer: `trunnion-diagnosis/1`.
    pub fn results(&self) -> results::Diagnosis {
        self.diagnosis().into()
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::diagnosis_text(&self.results())
    }

    /// The effect or formula that leads, if the verdict names one.
    pub fn best(&self) -> Option<String> {
        self.results().best()
    }

    /// Adds an effect to the model and fits again.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn add(&self, effect: &str) -> Result<Step, Error> {
        self.fit.add(effect)
    }

    /// Predicts other runs with the values of the fit.
    ///
    /// # Errors
    /// As [`Fit::predict`].
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        self.fit.predict(other)
    }
}
