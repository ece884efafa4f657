//! A whole analysis: identify, diagnose, add, and again until nothing is missing. The same for a live run, a replay and the demo.

use crate::compared::left_out;
use crate::{Compared, Diagnosed, Error, Experiment, Fit, Model, Step};
use trunnion_results::Verdict;

/// What a whole analysis found.
pub struct Analysed {
    before: Fit,
    steps: Vec<Step>,
    diagnoses: Vec<Diagnosed>,
    left_out: Vec<String>,
}

/// Most effects that an analysis adds by itself.
const MOST_STEPS: usize = 5;

impl Experiment {
    /// Adds what is missing, best first, until the diagnosis finds nothing more or names no single effect; `date` goes into the
    /// ladder rows.
    ///
    /// # Errors
    /// When the fit of the model fails. A diagnosis that fails judges nothing and a step that fails is left out, with the reason.
    pub fn analyse(&self, model: &Model, date: &str) -> Result<Analysed, Error> {
        let before = self.fit(model)?;
        let (mut steps, mut diagnoses): (Vec<Step>, Vec<Diagnosed>) = Default::default();
        loop {
            let diagnosed = Diagnosed::or_not_judged(steps.last().map_or(&before, Step::fit));
            let missing = diagnosed.results().verdict == Verdict::MissingEffect && steps.len() < MOST_STEPS;
            let added = |effect: String| {
                let step = diagnosed.add(&effect).and_then(|step| step.dated(date));
                step.map_err(|error| left_out(&format!("A further step with {effect}"), &error))
            };
            let (step, failed) = match diagnosed.best().filter(|_| missing).map(added) {
                Some(Ok(step)) => (Some(step), None),
                Some(Err(failed)) => (None, Some(failed)),
                None => (None, None),
            };
            // What is reported is planned for: the first diagnosis and the last.
            let reported = diagnoses.is_empty() || step.is_none();
            diagnoses.push(if reported { diagnosed.planned() } else { diagnosed });
            match step {
                Some(step) => steps.push(step),
                None => {
                    let left_out = failed.into_iter().collect();
                    return Ok(Analysed { before, steps, diagnoses, left_out });
                }
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

    /// Steps that failed and were left out, one sentence each.
    pub fn left_out(&self) -> &[String] {
        &self.left_out
    }

    /// Ids of the effects that were added.
    pub fn added(&self) -> Vec<&str> {
        self.steps.iter().map(Step::effect).collect()
    }

    /// Where the final model fails, with the steps that were left out on the way to it.
    pub fn compare(&self) -> Compared {
        self.last().compare().with_left_out(&self.left_out)
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_comparison_names_the_steps_that_were_left_out() {
        let points =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/points-nothing-hidden/points.csv");
        let run = crate::open(points).expect("committed points");
        let mut analysed = run.analyse(&run.base_model(), "").expect("they can be fitted");
        analysed
            .left_out
            .push("A further step with backlash:C is left out, because it failed: no fit.".into());
        assert_eq!(analysed.compare().results().left_out, analysed.left_out());
    }
}
