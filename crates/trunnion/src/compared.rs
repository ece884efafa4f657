//! Where a model fails, and what one more effect would do: values, text and page.

use crate::analysis::FormulaText;
use crate::{Diagnosed, Error, Fit, Step, page};
use trunnion_effects::catalogue::BASE;
use trunnion_engine::spectrum::spectra;
use trunnion_results as results;

/// The residual of a fit, with what is missing from its model.
pub struct Compared {
    diagnosed: Diagnosed,
    answer: results::Comparison,
}

/// The fits without and with one more effect; the model stays as it is.
pub struct Trial {
    answer: results::Trial,
}

impl Fit {
    /// Where the model fails, with what is missing from it.
    ///
    /// # Errors
    /// When the diagnosis fails.
    pub fn compare(&self) -> Result<Compared, Error> {
        self.diagnose()?.compare()
    }

    /// What one more effect would do; the model stays as it is. `text` is what a user says of the expression of a formula.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn try_effect(&self, effect: &str, text: &FormulaText) -> Result<Trial, Error> {
        if self.model().effects().contains(&effect) || BASE.contains(&effect) {
            return Err(Error::InModel { effect: effect.into() });
        }
        Trial::of(&self.add_as(effect, text)?)
    }
}

impl Diagnosed {
    /// Where the model fails.
    ///
    /// # Errors
    /// When the fit behind the delays of a run on the fly fails.
    pub fn compare(&self) -> Result<Compared, Error> {
        let (fit, diagnosis) = (self.fit(), self.results());
        let spectra = match diagnosis.verdict {
            results::Verdict::NotJudged => Vec::new(),
            // A side note that fails costs no report.
            _ => spectra(&fit.problem()).iter().flatten().map(results::AxisSpectrum::from).collect(),
        };
        let answer = results::Comparison {
            spectra,
            losses: fit.experiment().losses().to_vec(),
            time_quality: fit.experiment().time_quality(),
            ladder: fit.model().ladder(),
            correctable: Some(fit.correctable()?),
            identification: fit.results(),
            ..results::Comparison::new(fit.experiment().points(), fit.identification(), Some(diagnosis))
        };
        Ok(Compared { diagnosed: self.clone(), answer })
    }
}

impl Compared {
    /// With what else is known to be missing, one sentence each; what the recordings say themselves is said once.
    #[must_use]
    pub fn with_losses(mut self, losses: &[String]) -> Self {
        for loss in losses {
            // Of several runs a sentence begins with the name of its run.
            if !self.answer.losses.iter().any(|known| known.ends_with(loss)) {
                self.answer.losses.push(loss.clone());
            }
        }
        self
    }

    /// With what is known of further runs in time.
    #[must_use]
    pub fn with_time_quality(mut self, further: &[results::TimeQuality]) -> Self {
        self.answer.time_quality.extend_from_slice(further);
        self
    }

    /// The answer: `trunnion-comparison/1`.
    pub fn results(&self) -> results::Comparison {
        self.answer.clone()
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::compare_text(&self.answer)
    }

    /// The answer in the order of a page: `trunnion-story/1`.
    pub fn story(&self) -> results::Story {
        trunnion_report::story(&self.answer)
    }

    /// The diagnosis behind it.
    pub fn diagnosed(&self) -> &Diagnosed {
        &self.diagnosed
    }

    /// The answer as a page of its own.
    pub fn page(&self) -> String {
        trunnion_report::compare_html(&self.answer, &page::label())
    }

    /// The same with the best candidate put in for a trial.
    ///
    /// # Errors
    /// When the fit with the best candidate fails.
    pub fn with_best(mut self) -> Result<Self, Error> {
        if let Some(effect) = self.diagnosed.best() {
            self.answer.trial = Some(Trial::of(&self.diagnosed.add(&effect)?)?.answer);
        }
        Ok(self)
    }
}

impl Trial {
    fn of(step: &Step) -> Result<Self, Error> {
        let then = Diagnosed::without_plan(step.fit())?.results();
        let fits = [step.before(), step.fit()].map(Fit::identification);
        let points = step.fit().experiment().points();
        let answer = results::Trial::new(points, step.whole_entry(), step.entries(), fits, Some(&then));
        Ok(Self { answer })
    }

    /// The answer: `trunnion-trial/1`.
    pub fn results(&self) -> results::Trial {
        self.answer.clone()
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::trial_text(&self.answer)
    }

    /// The answer as a page of its own.
    pub fn page(&self) -> String {
        trunnion_report::trial_html(&self.answer, &page::label())
    }
}
