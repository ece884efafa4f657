//! Where a model fails, and what one more effect would do: values, text and page.

use crate::analysis::FormulaText;
use crate::{Error, Fit, Step, analysis, page};
use trunnion_effects::Formula;
use trunnion_effects::catalogue::BASE;
use trunnion_engine::{Diagnosis, compare};
use trunnion_report::CompareInput;
use trunnion_results as results;
use trunnion_results::{BeforeAfter, Place, PlacesBeforeAfter, Then};

/// The residual of a fit, with what is missing from its model.
pub struct Compared {
    fit: Fit,
    diagnosis: Diagnosis,
    shown: CompareInput,
}

/// The fits without and with one more effect; the model stays as it is.
pub struct Trial {
    step: Step,
    shown: trunnion_report::Trial,
}

impl Compared {
    pub(crate) fn of(fit: &Fit) -> Result<Self, Error> {
        let (points, model) = (fit.experiment().points(), fit.model().entries());
        let diagnosis = analysis::diagnose_and_plan(points, model)?;
        let timing = fit.experiment().time_quality()?;
        let shown = page::compare_input(points, fit.identification(), Some(&diagnosis), model, &[], &timing);
        Ok(Self { fit: fit.clone(), diagnosis, shown })
    }

    /// The answer: `trunnion-comparison/1`.
    pub fn results(&self) -> results::Comparison {
        results::Comparison {
            time_quality: self.shown.timing.clone(),
            places: self.shown.places.iter().map(Place::from).collect(),
            identification: self.shown.identification.clone(),
            diagnosis: (&self.diagnosis).into(),
            ..results::Comparison::default()
        }
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::compare_text(&self.shown)
    }

    /// The answer as a page of its own, with the best candidate at work; `date` goes into nothing that is kept.
    ///
    /// # Errors
    /// When the fit with the best candidate fails.
    pub fn page(&self) -> Result<String, Error> {
        let mut shown = self.shown.clone();
        if let Some(effect) = results::Diagnosis::from(&self.diagnosis).best() {
            let (points, model) = (self.fit.experiment().points(), self.fit.model().entries());
            let entries = match &self.diagnosis.formula {
                Some(formula) if Formula::name_of(&effect).is_some() => formula.entries.clone(),
                _ => analysis::entries(points, model, &effect, &FormulaText::default())?,
            };
            let step = analysis::put(points, model, entries, "")?;
            let then = analysis::diagnose(points, &step.model)?;
            shown.trial = Some(trunnion_report::Trial::new(
                points,
                &step.entry,
                &step.entries,
                &step.before,
                &step.identification,
                Some((&then).into()),
            ));
        }
        Ok(trunnion_report::compare_html(&shown))
    }
}

impl Trial {
    pub(crate) fn of(fit: &Fit, effect: &str, told: &FormulaText) -> Result<Self, Error> {
        if fit.model().effects().contains(&effect) || BASE.contains(&effect) {
            return Err(Error::InModel { effect: effect.into() });
        }
        let step = Step::of(fit, effect, told)?;
        let points = fit.experiment().points();
        let then = analysis::diagnose(points, step.model().entries())?;
        let shown = trunnion_report::Trial::new(
            points,
            step.whole_entry(),
            step.entries(),
            step.before().identification(),
            step.fit().identification(),
            Some((&then).into()),
        );
        Ok(Self { step, shown })
    }

    /// The answer: `trunnion-trial/1`.
    pub fn results(&self) -> results::Trial {
        let shown = &self.shown;
        let places = |places: &[compare::Place]| places.iter().map(Place::from).collect();
        results::Trial {
            effect: shown.effect.clone(),
            rms_um: BeforeAfter { before: Some(shown.fit_um[0]), after: Some(shown.fit_um[1]) },
            holdout_rms_um: BeforeAfter { before: shown.holdout_um[0], after: shown.holdout_um[1] },
            noise_um: shown.noise.rms_um,
            then: shown.then.as_ref().map(Then::from),
            places: PlacesBeforeAfter { before: places(&shown.places[0]), after: places(&shown.places[1]) },
            moved: Some(shown.moved.clone()),
            identification: self.step.fit().results(),
            ..results::Trial::default()
        }
    }

    /// The answer as text.
    pub fn summary(&self) -> String {
        trunnion_report::trial_text(&self.shown)
    }

    /// The answer as a page of its own.
    pub fn page(&self) -> String {
        let before = self.step.before();
        let points = before.experiment().points();
        let input =
            CompareInput { label: page::label(), ..CompareInput::new(points, before.identification(), None) };
        trunnion_report::trial_html(&input, &self.shown)
    }
}
