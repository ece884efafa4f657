//! Where a model fails, and what one more effect would do: values, text and page.

use crate::analysis::FormulaText;
use crate::{Diagnosed, Error, Fit, Step, added, page};
use trunnion_core::chain;
use trunnion_effects::catalogue::BASE;
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
    /// Where the model fails, with what is missing from it; where no diagnosis is possible, without a verdict and with the reason.
    pub fn compare(&self) -> Compared {
        Diagnosed::or_not_judged(self).planned().compare()
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
    /// Where the model fails. A side note that fails is left out with its reason and costs no report.
    pub fn compare(&self) -> Compared {
        let (fit, diagnosis) = (self.fit(), self.results());
        let (spectra, added) = match diagnosis.verdict {
            results::Verdict::NotJudged => (Vec::new(), Ok(Vec::new())),
            _ => (added::spectra_of(fit), added::trials(fit, &diagnosis)),
        };
        let correctable = fit.correctable();
        let left_out = [
            correctable.as_ref().err().map(|error| left_out(CORRECTABLE, error)),
            added.as_ref().err().map(|error| left_out(ADDED, error)),
        ];
        let answer = results::Comparison {
            spectra,
            added: added.unwrap_or_default(),
            losses: fit.experiment().losses(),
            time_quality: fit.experiment().time_quality(),
            ladder: fit.model().ladder(),
            correctable: correctable.ok(),
            left_out: left_out.into_iter().flatten().collect(),
            identification: fit.results().judged(diagnosis.model_adequate()),
            ..results::Comparison::new(fit.experiment().points(), fit.identification(), Some(diagnosis))
        };
        Compared { diagnosed: self.clone(), answer }
    }
}

impl Compared {
    /// With what else is known to be missing, one sentence each; what the recordings say themselves is said once.
    #[must_use]
    pub fn with_losses(mut self, losses: &[String]) -> Self {
        for loss in losses {
            // Of several runs a sentence begins with the name of its run.
            let of_run = format!(": {loss}");
            if !self.answer.losses.iter().any(|known| known == loss || known.ends_with(&of_run)) {
                self.answer.losses.push(loss.clone());
            }
        }
        self.answer.identification.complete.losses.clone_from(&self.answer.losses);
        self
    }

    /// With what was left out on the way to it, one sentence each.
    #[must_use]
    pub fn with_left_out(mut self, left_out: &[String]) -> Self {
        self.answer.left_out.extend_from_slice(left_out);
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

    /// The same with the best candidate put in for a trial; left out with its reason where that fails.
    #[must_use]
    pub fn with_best(mut self) -> Self {
        if let Some(effect) = self.diagnosed.best() {
            match self.diagnosed.add(&effect).and_then(|step| Trial::of(&step)) {
                Ok(trial) => self.answer.trial = Some(trial.answer),
                Err(error) => {
                    self.answer.left_out.push(left_out(&format!("A trial of {effect}"), &error));
                }
            }
        }
        self
    }
}

/// What may be left out of a comparison.
const CORRECTABLE: &str = "What could be entered into the control";
const ADDED: &str = "What was found before an effect was added";

pub(crate) fn left_out(what: &str, error: &Error) -> String {
    format!("{what} is left out, because it failed: {}.", chain(error))
}

impl Trial {
    fn of(step: &Step) -> Result<Self, Error> {
        let then = Diagnosed::without_plan(step.fit())?.results();
        let fits = [step.before(), step.fit()];
        Ok(Self { answer: added::trial(step.whole_entry(), step.entries(), fits, Some(&then)) })
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagnosis whose best candidate cannot be added: the model has it already.
    #[test]
    fn a_trial_that_fails_is_left_out_with_its_reason() {
        let points = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-gravity/points.csv");
        let run = crate::open(points).expect("committed points");
        let base = run.fit(&run.base_model()).expect("they can be fitted");
        let diagnosed = Diagnosed::without_plan(&base).expect("they can be judged");
        let best = diagnosed.best().expect("they lack an effect");
        let with_it = diagnosed.add(&best).expect("it can be added").fit().clone();
        let compared = diagnosed.of_fit(with_it).compare().with_best();
        assert!(compared.results().trial.is_none());
        let [left_out] = &compared.results().left_out[..] else { panic!("one is left out") };
        assert!(left_out.starts_with(&format!("A trial of {best} is left out")), "{left_out}");
        for surface in [compared.page(), compared.summary()] {
            assert!(surface.contains("is left out, because"), "{surface}");
        }
    }
}
