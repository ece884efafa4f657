//! An effect added to a model: the fits without and with it, and its ladder row.

use crate::analysis::{FormulaText, Put};
use crate::{Diagnosed, Error, Experiment, Fit, Model, analysis};
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Formula, LadderRow, ModelEffect, Removal};
use trunnion_results as results;
use trunnion_results::sentences::formula_id;

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

impl Fit {
    /// Adds an effect to the model and fits again. A `formula:NAME` takes the expression that the diagnosis proposes.
    ///
    /// # Errors
    /// An unknown effect or one that is in the model already, or a fit that fails.
    pub fn add(&self, effect: &str) -> Result<Step, Error> {
        self.add_as(effect, &FormulaText::default())
    }

    /// The same with what a user says of the expression of a formula. An effect that was written into the model file by hand, and
    /// has no ladder row yet, gets its row.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn add_as(&self, effect: &str, text: &FormulaText) -> Result<Step, Error> {
        let entries = &self.model().entries().effects;
        match entries.iter().position(|entry| entry.id == effect) {
            None => {
                Step::of(self, effect, analysis::entries(self.experiment(), &self.problem(), effect, text)?)
            }
            Some(at) => Step::of_held(self, at, written_by_hand(&entries[at], text)?),
        }
    }

    /// Takes an effect out of the model, and what came in with it by one act, fits again and measures the ladder rows after it again; `date` goes into them, and with the
    /// name of who removes it into the model.
    ///
    /// # Errors
    /// An effect that is not in the model, or is in every model; a model of another machine.
    pub fn remove(&self, effect: &str, date: &str, by: Option<&str>) -> Result<Self, Error> {
        self.model().is_of(self.experiment().runs())?;
        let entries = self.model().entries();
        let (smaller, fit) = analysis::remove(self.experiment(), entries, effect, date)?;
        let held = |id: &str| smaller.effects.iter().any(|entry| entry.id == id);
        let gone: Vec<&ModelEffect> = entries.effects.iter().filter(|old| !held(&old.id)).collect();
        let act = gone.first().map_or(effect, |entry| entry.added_as());
        let removal = Removal { effect: act.into(), date: date.into(), by: by.map(String::from) };
        let ids: Vec<&str> = gone.iter().map(|entry| entry.id.as_str()).collect();
        let mut model = self.model().without(&ids, &removal)?;
        for entry in &smaller.effects {
            let old = entries.effects.iter().find(|old| old.id == entry.id);
            if let Some(row) =
                entry.ladder.as_ref().filter(|_| old.is_none_or(|old| old.ladder != entry.ladder))
            {
                model = model.with_ladder_row(&entry.id, row)?;
            }
        }
        let smaller = Self::of(self.experiment(), model, fit);
        // Values that the last entry kept from its own adding count again; else they are of this fit.
        let base_alone = smaller.model().effects().iter().all(|id| BASE.contains(id));
        if base_alone || smaller.model().entries().values().is_some() {
            return Ok(smaller);
        }
        let model = smaller.keeping(date)?;
        Ok(smaller.with_model(model))
    }
}

impl Diagnosed {
    /// Adds an effect to the model and fits again.
    ///
    /// # Errors
    /// As [`Fit::add`].
    pub fn add(&self, effect: &str) -> Result<Step, Error> {
        match &self.diagnosis().formula {
            Some(formula) if Formula::name_of(effect) == Some(formula.name.as_str()) => {
                Step::of(self.fit(), effect, formula.entries.clone())
            }
            _ => self.fit().add(effect),
        }
    }
}

impl Step {
    /// New entries at the end of the model.
    pub(crate) fn of(fit: &Fit, effect: &str, entries: Vec<ModelEffect>) -> Result<Self, Error> {
        let put = analysis::put(&fit.problem(), entries, "")?;
        let larger = fit.model().with(&put.entries)?;
        Ok(Self::new(fit.clone(), larger, effect, put))
    }

    /// The entry at this place of the model, measured on top of those before it.
    fn of_held(fit: &Fit, at: usize, entry: ModelEffect) -> Result<Self, Error> {
        let mut shorter = fit.model().entries().clone();
        shorter.effects.truncate(at);
        let before = fit.experiment().fit(&shorter.into())?;
        let effect = entry.id.clone();
        let put = analysis::put(&before.problem(), vec![entry], "")?;
        let row = put.whole.ladder.clone().unwrap_or_default();
        let larger = fit.model().with_ladder_row(&effect, &row)?;
        if at + 1 == fit.model().entries().effects.len() {
            return Ok(Self::new(before, larger, &effect, put));
        }
        // Entries after it stay in the model, above its row.
        let after = fit.experiment().fit(&larger)?;
        Ok(Self { after, ..Self::new(before, larger, &effect, put) })
    }

    fn new(before: Fit, larger: Model, effect: &str, put: Put) -> Self {
        Self {
            effect: effect.into(),
            after: Fit::of(before.experiment(), larger, put.fit),
            row: put.whole.ladder.clone().unwrap_or_default(),
            whole: put.whole,
            entries: put.entries,
            before,
        }
    }

    /// The same with a date in its ladder rows, with what a diagnosis says for the effect, and with the values of the fit in the model.
    ///
    /// # Errors
    /// A model of another machine than that of the runs: its file would hold values of two.
    pub fn dated(mut self, date: &str) -> Result<Self, Error> {
        self.after.model().is_of(self.after.experiment().runs())?;
        self.row = self.as_found(LadderRow { date: date.into(), ..self.row.clone() });
        let mut model = self.after.model().clone();
        for entry in &mut self.entries {
            if let Some(row) = &mut entry.ladder {
                row.date = date.into();
                // What came in with another has its grounds in the row of that one.
                if row.with.is_none() {
                    row.evidence = self.row.evidence;
                    row.confused_with.clone_from(&self.row.confused_with);
                    row.separate_by.clone_from(&self.row.separate_by);
                }
                model = model.with_ladder_row(&entry.id, row)?;
            }
        }
        let model = model.with_values(&self.after.values(date))?;
        self.after = self.after.with_model(model);
        Ok(self)
    }

    /// A row with what a diagnosis of the model without the effect says for it. That was mostly asked before, and is kept.
    fn as_found(&self, row: LadderRow) -> LadderRow {
        let diagnosis = Diagnosed::or_not_judged(&self.before).results();
        let formula = diagnosis.formula.as_ref().filter(|formula| formula_id(formula) == self.effect);
        match diagnosis.candidates.iter().find(|candidate| candidate.effect == self.effect) {
            Some(candidate) => LadderRow {
                evidence: Some(candidate.evidence),
                confused_with: candidate.confused_with.clone(),
                separate_by: candidate.separate_by.clone(),
                ..row
            },
            None => LadderRow { evidence: formula.map(|formula| formula.evidence), ..row },
        }
    }

    /// The same with the name of who added it in its ladder rows.
    ///
    /// # Errors
    /// None that a model written by this program can have.
    pub fn by(mut self, name: &str) -> Result<Self, Error> {
        self.row.by = Some(name.into());
        let mut model = self.after.model().clone();
        for entry in &mut self.entries {
            if let Some(row) = &mut entry.ladder {
                row.by = Some(name.into());
                model = model.with_ladder_row(&entry.id, row)?;
            }
        }
        self.after = self.after.with_model(model);
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

    /// What adding it did to the error, as the model file holds it: of all entries of a formula of several components.
    pub fn row(&self) -> LadderRow {
        let of_model = self.model().entries().effects.iter().find(|entry| entry.id == self.effect);
        of_model.and_then(|entry| entry.ladder.as_ref()).unwrap_or(&self.row).clone()
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
        let ladder = trunnion_report::ladder_text(&self.ladder(), self.row().noise_um);
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

/// The entry, when it waits for its ladder row.
fn written_by_hand(entry: &ModelEffect, text: &FormulaText) -> Result<ModelEffect, Error> {
    let waits = entry.ladder.is_none() && !BASE.contains(&entry.id.as_str());
    if waits && *text == FormulaText::default() {
        Ok(entry.clone())
    } else {
        Err(Error::InModel { effect: entry.id.clone() })
    }
}
