//! An effect added to a model: the fits without and with it, and its ladder row.

use crate::analysis::FormulaText;
use crate::{Diagnosed, Error, Experiment, Fit, Model, analysis};
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{LadderRow, ModelEffect};
use trunnion_results as results;

/// An effect added to a model.
#[derive(Clone)]
pub struct Step {
    effect: String,
    /// What was added, with the ladder row of all of it.
    whole: ModelEffect,
    row: LadderRow,
    entries: Vec<ModelEffect>,
    before: Fit,
    after: Fit,
}

impl Step {
    pub(crate) fn of(fit: &Fit, effect: &str, told: &FormulaText) -> Result<Self, Error> {
        let (experiment, model) = (fit.experiment(), fit.model());
        let held = model.entries().effects.iter().position(|entry| entry.id == effect);
        let (step, larger) = match held {
            None => {
                let entries = analysis::entries(experiment.points(), model.entries(), effect, told)?;
                let step = analysis::put(experiment.points(), model.entries(), entries, "")?;
                let larger = model.with(&step.entries)?;
                (step, larger)
            }
            Some(at) => {
                let entry = written_by_hand(&model.entries().effects[at], told)?;
                let mut shorter = model.entries().clone();
                shorter.effects.truncate(at);
                let step = analysis::put(experiment.points(), &shorter, vec![entry], "")?;
                let larger = model.with_ladder_row(effect, &row_of(&step))?;
                (step, larger)
            }
        };
        let before = Fit::of(experiment, fit.model().clone(), step.before.clone());
        Ok(Self {
            effect: effect.into(),
            row: row_of(&step),
            whole: step.entry,
            after: Fit::of(experiment, larger, step.identification),
            entries: step.entries,
            before,
        })
    }

    /// The same with a date in its ladder rows.
    ///
    /// # Errors
    /// None that a model written by this program can have.
    pub fn dated(mut self, date: &str) -> Result<Self, Error> {
        self.row.date = date.into();
        let mut model = self.after.model().clone();
        for entry in &mut self.entries {
            if let Some(row) = &mut entry.ladder {
                row.date = date.into();
                model = model.with_ladder_row(&entry.id, row)?;
            }
        }
        self.after = Fit::of(self.after.experiment(), model, self.after.identification().clone());
        Ok(self)
    }

    /// The effect.
    pub fn effect(&self) -> &str {
        &self.effect
    }

    /// The fit without it.
    pub fn before(&self) -> &Fit {
        &self.before
    }

    /// The fit with it.
    pub fn fit(&self) -> &Fit {
        &self.after
    }

    /// The model with it.
    pub fn model(&self) -> &Model {
        self.after.model()
    }

    /// The entries that it put into the model: a formula of several components is one entry for each.
    pub fn entries(&self) -> &[ModelEffect] {
        &self.entries
    }

    /// What was added as one entry, with the ladder row of all of it.
    pub(crate) fn whole_entry(&self) -> &ModelEffect {
        &self.whole
    }

    /// What adding it did to the error: as the model file holds it, or of all entries of a formula of several components.
    pub fn row(&self) -> results::LadderRow {
        let of_model = self.model().entries().effects.iter().find(|entry| entry.id == self.effect);
        match of_model.and_then(|entry| entry.ladder.as_ref()).filter(|_| self.entries.len() == 1) {
            Some(row) => row.into(),
            None => (&self.row).into(),
        }
    }

    /// The ladder of the model with it.
    pub fn ladder(&self) -> results::Ladder {
        self.model().ladder()
    }

    /// The answer; `model` is the name of the model file.
    pub fn results(&self, model: &str) -> results::Added {
        results::Added {
            effect: self.effect.clone(),
            model: model.into(),
            row: self.row(),
            identification: self.after.results(),
        }
    }

    /// The answer as text: the ladder, then the fit.
    pub fn summary(&self) -> String {
        let ladder = crate::page::ladder(self.model().entries());
        let ladder = trunnion_report::ladder_text(&ladder, self.row().noise_um);
        format!("{ladder}\n{}", self.after.summary())
    }

    /// What the model still lacks.
    ///
    /// # Errors
    /// As [`Fit::diagnose`].
    pub fn diagnose(&self) -> Result<Diagnosed, Error> {
        self.after.diagnose()
    }

    /// Adds one more effect.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn add(&self, effect: &str) -> Result<Self, Error> {
        self.after.add(effect)
    }

    /// Predicts other runs with the values of the fit.
    ///
    /// # Errors
    /// As [`Fit::predict`].
    pub fn predict(&self, other: &Experiment) -> Result<results::Prediction, Error> {
        self.after.predict(other)
    }
}

fn row_of(step: &analysis::Step) -> LadderRow {
    step.entry.ladder.clone().unwrap_or_default()
}

/// The entry, when it waits for its ladder row.
fn written_by_hand(entry: &ModelEffect, told: &FormulaText) -> Result<ModelEffect, Error> {
    let waits = entry.ladder.is_none() && !BASE.contains(&entry.id.as_str());
    if waits && *told == FormulaText::default() {
        Ok(entry.clone())
    } else {
        Err(Error::InModel { effect: entry.id.clone() })
    }
}
