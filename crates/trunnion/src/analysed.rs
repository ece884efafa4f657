//! A whole analysis: identify, diagnose, add, and again until nothing is missing. The same for a live run, a replay and the demo.

use crate::{Compared, Diagnosed, Error, Experiment, Fit, Model, Step};
use trunnion_results::Verdict;

/// What a whole analysis found.
pub struct Analysed {
    before: Fit,
    steps: Vec<Step>,
    diagnoses: Vec<Diagnosed>,
}

/// Most effects that an analysis adds by itself.
const MOST_STEPS: usize = 5;

impl Experiment {
    /// Adds what is missing, best first, until the diagnosis finds nothing more or names no single effect; `date` goes into the
    /// ladder rows.
    ///
    /// # Errors
    /// When a fit or a diagnosis fails.
    pub fn analyse(&self, model: &Model, date: &str) -> Result<Analysed, Error> {
        let before = self.fit(model)?;
        let (mut steps, mut diagnoses): (Vec<Step>, Vec<Diagnosed>) = Default::default();
        loop {
            let diagnosed = Diagnosed::without_plan(steps.last().map_or(&before, Step::fit))?;
            let missing = diagnosed.results().verdict == Verdict::MissingEffect && steps.len() < MOST_STEPS;
            let step = match diagnosed.best().filter(|_| missing) {
                Some(effect) => Some(diagnosed.add(&effect)?.dated(date)?),
                None => None,
            };
            // What is reported is planned for: the first diagnosis and the last.
            let reported = diagnoses.is_empty() || step.is_none();
            diagnoses.push(if reported { diagnosed.planned() } else { diagnosed });
            match step {
                Some(step) => steps.push(step),
                None => return Ok(Analysed { before, steps, diagnoses }),
            }
        }
    }
}

impl Analysed {
    /// The fit of the model that was given.
    pub fn before(&self) -> &Fit {
        &self.before
    }

    /// Each effect added, in order.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The diagnosis before each step, and after the last.
    pub fn diagnoses(&self) -> &[Diagnosed] {
        &self.diagnoses
    }

    /// The diagnosis of the model that was given.
    pub fn first(&self) -> &Diagnosed {
        &self.diagnoses[0]
    }

    /// The diagnosis of the final model.
    pub fn last(&self) -> &Diagnosed {
        &self.diagnoses[self.steps.len()]
    }

    /// The fit of the final model.
    pub fn fit(&self) -> &Fit {
        self.last().fit()
    }

    /// Ids of the effects that were added.
    pub fn added(&self) -> Vec<&str> {
        self.steps.iter().map(Step::effect).collect()
    }

    /// Where the final model fails.
    ///
    /// # Errors
    /// As [`Diagnosed::compare`].
    pub fn compare(&self) -> Result<Compared, Error> {
        self.last().compare()
    }
}
