//! From points to an answer: identify, diagnose, add, and again until nothing is missing.
//!
//! The same path for a live run, a replay, an import and the demo. Pure: the caller writes the files.

use trunnion_diagnose::{DiagnoseError, Diagnosis, Verdict};
use trunnion_effects::model::LadderRow;
use trunnion_effects::{Model, ModelEffect};
use trunnion_identify::{Experiment, Identification, IdentifyError};
use trunnion_units::convert;

/// What an analysis can fail on.
#[derive(Debug, thiserror::Error)]
pub enum AnalysisError {
    /// The fit failed.
    #[error("identifying the machine's errors failed")]
    Identify(#[from] IdentifyError),
    /// The diagnosis failed.
    #[error("looking for missing effects failed")]
    Diagnose(#[from] DiagnoseError),
    /// A formula that nobody proposed.
    #[error(
        "there is no expression for {id}; `trunnion diagnose` proposes {proposed}. \
             Or write the formula into the model file by hand"
    )]
    NoSuchFormula {
        /// What was asked for.
        id: String,
        /// What the diagnosis proposes now.
        proposed: String,
    },
}

/// An effect added to a model.
pub struct Step {
    /// The model with the effect.
    pub model: Model,
    /// The new entry, with its ladder row.
    pub entry: ModelEffect,
    /// The fit of the new model.
    pub identification: Identification,
}

/// What a whole analysis found.
pub struct Analysis {
    /// Fit of the model that was given.
    pub before: Identification,
    /// Each effect added, in order.
    pub steps: Vec<Step>,
    /// Diagnosis before each step and after the last.
    pub diagnoses: Vec<Diagnosis>,
    /// The final model.
    pub model: Model,
}

impl Analysis {
    /// Fit of the final model.
    pub fn identification(&self) -> &Identification {
        self.steps.last().map_or(&self.before, |step| &step.identification)
    }

    /// The last word of the diagnosis.
    pub fn diagnosis(&self) -> &Diagnosis {
        self.diagnoses.last().expect("an analysis diagnoses at least once")
    }
}

/// Most effects that an analysis adds by itself.
const MOST_STEPS: usize = 5;

/// Adds what is missing, best first, until the diagnosis finds nothing more or names no single effect.
///
/// # Errors
/// When a fit or a diagnosis fails.
pub fn climb(experiment: &Experiment, model: &Model, date: &str) -> Result<Analysis, AnalysisError> {
    let before = trunnion_identify::identify(experiment, model, &trunnion_identify::Options::default())?;
    let mut analysis = Analysis { before, steps: Vec::new(), diagnoses: Vec::new(), model: model.clone() };
    loop {
        let diagnosis = diagnose(experiment, &analysis.model)?;
        let best = match diagnosis.verdict {
            Verdict::MissingEffect => diagnosis.candidates.first().map(|candidate| candidate.effect.clone()),
            Verdict::UnnamedStructure | Verdict::NoiseFloor => None,
        };
        analysis.diagnoses.push(diagnosis);
        let Some(effect) = best.filter(|_| analysis.steps.len() < MOST_STEPS) else { return Ok(analysis) };
        let step = add(experiment, &analysis.model, &effect, date)?;
        analysis.model = step.model.clone();
        analysis.steps.push(step);
    }
}

/// Diagnoses with the default options.
///
/// # Errors
/// When the model does not fit the runs.
pub fn diagnose(experiment: &Experiment, model: &Model) -> Result<Diagnosis, DiagnoseError> {
    trunnion_diagnose::diagnose(experiment, model, &trunnion_diagnose::Options::default())
}

/// Adds one effect to a model and refits. A `formula:NAME` takes the expression the diagnosis proposes.
///
/// # Errors
/// When a fit fails or nobody proposed the formula.
pub fn add(experiment: &Experiment, model: &Model, id: &str, date: &str) -> Result<Step, AnalysisError> {
    let options = trunnion_identify::Options::default();
    let before = trunnion_identify::identify(experiment, model, &options)?;
    let mut entry = entry(experiment, model, id)?;
    let mut larger = model.clone();
    larger.effects.push(entry.clone());
    let identification = trunnion_identify::identify(experiment, &larger, &options)?;
    let holdout_um =
        |fit: &Identification| fit.holdout.as_ref().map(|holdout| convert::um_from_mm(holdout.rms_mm));
    entry.ladder = Some(LadderRow {
        date: date.into(),
        run: experiment.runs.join(", "),
        error_before_um: convert::um_from_mm(before.rms_mm),
        error_after_um: convert::um_from_mm(identification.rms_mm),
        holdout_before_um: holdout_um(&before),
        holdout_after_um: holdout_um(&identification),
        noise_um: convert::um_from_mm(identification.noise.sigma_mm),
    });
    if let Some(last) = larger.effects.last_mut() {
        *last = entry.clone();
    }
    Ok(Step { model: larger, entry, identification })
}

fn entry(experiment: &Experiment, model: &Model, id: &str) -> Result<ModelEffect, AnalysisError> {
    let Some(name) = id.strip_prefix("formula:") else {
        return Ok(ModelEffect { id: id.into(), ..ModelEffect::default() });
    };
    let proposal = diagnose(experiment, model)?.formula;
    match proposal {
        Some(formula) if formula.name == name => Ok(ModelEffect {
            id: id.into(),
            site: Some(formula.site),
            component: Some(formula.component),
            expression: Some(formula.expression),
            ..ModelEffect::default()
        }),
        other => Err(AnalysisError::NoSuchFormula {
            id: id.into(),
            proposed: other.map_or("none now".into(), |formula| format!("formula:{}", formula.name)),
        }),
    }
}
