//! A fit together with its diagnosis.

use crate::analysis::diagnosed;
use crate::{Error, Experiment, Fit};
use std::convert::Infallible;
use std::sync::Arc;
use trunnion_core::chain;
use trunnion_core::number::plain;
use trunnion_engine::{Diagnosis, next_cycle};
use trunnion_results as results;

/// A fit, and what its model lacks. Clones share the data.
#[derive(Clone)]
pub struct Diagnosed {
    fit: Fit,
    diagnosis: Arc<Diagnosis>,
}

impl Fit {
    /// Which effect the model lacks; where candidates are confused, the cycle that separates them is planned too.
    ///
    /// # Errors
    /// Too few readings to judge the model.
    pub fn diagnose(&self) -> Result<Diagnosed, Error> {
        Ok(Diagnosed::without_plan(self)?.planned())
    }
}

impl Fit {
    /// The answer of a diagnosis in one word, and why where nothing is claimed; not judged where the diagnosis fails.
    pub fn verdict(&self) -> (results::Verdict, String) {
        let answer = Diagnosed::or_not_judged(self).results();
        let named = answer.named();
        let found = match answer.missing_um() {
            _ if named.is_empty() => answer.why,
            Some(missing) => {
                format!("It lacks {} ({} µm rms of the readings).", named.join("; "), plain(missing))
            }
            None => format!("It lacks {}.", named.join("; ")),
        };
        (answer.verdict, found)
    }
}

impl Diagnosed {
    /// What the model lacks, without a plan for the next cycle.
    pub(crate) fn without_plan(fit: &Fit) -> Result<Self, Error> {
        let implausible = fit.experiment().plausibility();
        let diagnosis = match implausible.is_empty() {
            true => diagnosed(fit.experiment(), &fit.problem())?,
            false => Diagnosis::not_judged(&fit.problem(), results::sentences::not_plausible(&implausible)),
        };
        Ok(Self { fit: fit.clone(), diagnosis: Arc::new(diagnosis) })
    }

    /// The same; where a diagnosis fails, nothing is judged and the reason is said.
    pub(crate) fn or_not_judged(fit: &Fit) -> Self {
        Self::without_plan(fit).unwrap_or_else(|error| {
            let why = format!("The diagnosis failed: {}.", chain(&error));
            let diagnosis = Arc::new(Diagnosis::not_judged(&fit.problem(), why));
            Self { fit: fit.clone(), diagnosis }
        })
    }

    /// With the cycle that separates what is confused.
    pub(crate) fn planned(self) -> Self {
        let (diagnosis, problem) = (self.diagnosis(), self.fit.problem());
        let advised = || {
            let mut diagnosis = diagnosis.clone();
            next_cycle::advise(&problem, &mut diagnosis, &next_cycle::Options::default());
            Ok::<_, Infallible>(diagnosis.next_cycle)
        };
        let Ok(next_cycle) =
            self.fit.experiment().kept().answer("next cycle", (problem.model(), diagnosis), advised);
        let diagnosis = Arc::new(Diagnosis { next_cycle, ..diagnosis.clone() });
        Self { diagnosis, ..self }
    }

    /// The same diagnosis said of another fit.
    #[cfg(test)]
    pub(crate) fn of_fit(&self, fit: Fit) -> Self {
        Self { fit, diagnosis: self.diagnosis.clone() }
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
        results::Diagnosis { complete: self.fit.complete(), ..self.diagnosis().into() }
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        let diagnosis = self.results();
        trunnion_report::diagnosis_text(&results::Comparison {
            identification: self.fit.results().judged(diagnosis.model_adequate()),
            correctable: self.fit.correctable().ok(),
            diagnosis: Some(diagnosis),
            ..results::Comparison::default()
        })
    }

    /// The effect or formula that leads, if the verdict names one.
    pub fn best(&self) -> Option<String> {
        self.results().best()
    }

    /// Predicts other runs with the values of the fit.
    ///
    /// # Errors
    /// As [`Fit::predict`].
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        self.fit.predict(other)
    }
}
