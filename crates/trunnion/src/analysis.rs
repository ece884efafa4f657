//! From points to an answer: identify, diagnose, add, and again until nothing is missing.
//!
//! The same path for a live run, a replay, an import and the demo. Pure: the caller writes the files.

use trunnion_core::convert;
use trunnion_effects::catalogue::{BASE, LOCATION_ERRORS};
use trunnion_effects::{Formula, LadderRow, Model, ModelEffect, Moved};
use trunnion_engine::{
    DiagnoseError, Diagnosis, Experiment, FittedParameter, FormulaProposal, Identification, IdentifyError,
    Problem, Verdict, diagnose_problem, next_cycle,
};

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
        "there is no expression for {id}: the diagnosis proposes {proposed}; \
         give one with --site axis:B --component dz --expression \"k*sin(2*B)\", or write it into the model file"
    )]
    NoSuchFormula {
        /// What was asked for.
        id: String,
        /// What the diagnosis proposes now.
        proposed: String,
    },
    /// An expression for an effect that has its own.
    #[error("{id} has an equation of its own; site, component, expression and grid belong to formula:NAME")]
    NoFormula {
        /// What was asked for.
        id: String,
    },
    /// An effect that is not there.
    #[error("the model does not hold {id}; it holds {held}")]
    NotInModel {
        /// What was asked for.
        id: String,
        /// What can be removed.
        held: String,
    },
    /// An effect that every model has.
    #[error("{id} is in every model and cannot be removed; fix its parameters in the model file instead")]
    Base {
        /// What was asked for.
        id: String,
    },
}

/// What a user may say about an effect beyond its id; empty for most.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FormulaText {
    /// `axis:B`, `ball`, `spindle`, `reading`.
    pub site: Option<String>,
    /// `dx` … `ec`.
    pub component: Option<String>,
    /// Expression with named parameters.
    pub expression: Option<String>,
    /// Values to try of each parameter that enters non-linearly.
    pub grid: Vec<(String, Vec<f64>)>,
}

/// An effect put into a model, and the fits without and with it.
pub struct Step {
    /// The model with the effect.
    pub model: Model,
    /// What was added, with the ladder row of all of it.
    pub entry: ModelEffect,
    /// The new entries of the model, each with its own ladder row: a formula of several components is one entry for each.
    pub entries: Vec<ModelEffect>,
    /// The fit of the model without it.
    pub before: Identification,
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
    let first = Problem::new(experiment, model)?;
    let (mut analysis, last) = ascend(&first, date)?;
    // What is reported is planned for: the first diagnosis and the last.
    let steps = analysis.diagnoses.len();
    if steps > 1 {
        advise(&first, &mut analysis.diagnoses[0]);
    }
    advise(&last, &mut analysis.diagnoses[steps - 1]);
    Ok(analysis)
}

fn ascend<'a>(first: &Problem<'a>, date: &str) -> Result<(Analysis, Problem<'a>), AnalysisError> {
    let mut problem = first.clone();
    // The entries with their ladder rows; a problem knows nothing of those.
    let mut model = first.model().clone();
    let (mut steps, mut diagnoses) = (Vec::new(), Vec::new());
    loop {
        let diagnosis = diagnosed(&problem)?;
        let best = match diagnosis.verdict {
            Verdict::MissingEffect => diagnosis.candidates.first().map(|candidate| candidate.effect.clone()),
            Verdict::UnnamedStructure | Verdict::NoiseFloor => None,
        };
        diagnoses.push(diagnosis);
        let Some(effect) = best.filter(|_| steps.len() < MOST_STEPS) else {
            return Ok((Analysis { before: first.fit().clone(), steps, diagnoses, model }, problem));
        };
        let added = ModelEffect { id: effect, ..ModelEffect::default() };
        let (mut step, larger) = put_on(&problem, vec![added], date)?;
        model.effects.extend(step.entries.iter().cloned());
        step.model = model.clone();
        problem = larger;
        steps.push(step);
    }
}

fn diagnosed(problem: &Problem<'_>) -> Result<Diagnosis, DiagnoseError> {
    diagnose_problem(problem, &trunnion_engine::diagnosis::Options::default())
}

/// Diagnoses with the default options.
///
/// # Errors
/// When the model does not fit the runs.
pub fn diagnose(experiment: &Experiment, model: &Model) -> Result<Diagnosis, DiagnoseError> {
    diagnosed(&Problem::new(experiment, model)?)
}

/// Diagnoses, and where candidates are confused plans the cycle that tells them apart.
///
/// # Errors
/// When the model does not fit the runs.
pub fn diagnose_and_plan(experiment: &Experiment, model: &Model) -> Result<Diagnosis, DiagnoseError> {
    let problem = Problem::new(experiment, model)?;
    let mut diagnosis = diagnosed(&problem)?;
    advise(&problem, &mut diagnosis);
    Ok(diagnosis)
}

fn advise(problem: &Problem<'_>, diagnosis: &mut Diagnosis) {
    next_cycle::advise(problem, diagnosis, &next_cycle::Options::default());
}

/// Adds one effect to a model and refits. A `formula:NAME` takes the expression the diagnosis proposes.
///
/// # Errors
/// When a fit fails or nobody proposed the formula.
pub fn add(experiment: &Experiment, model: &Model, id: &str, date: &str) -> Result<Step, AnalysisError> {
    let problem = Problem::new(experiment, model)?;
    let entry = entry(id, &FormulaText::default())?;
    let entries = match is_complete(&entry) {
        true => vec![entry],
        false => proposed(diagnosed(&problem)?.formula, entry, &FormulaText::default())?,
    };
    Ok(put_on(&problem, entries, date)?.0)
}

/// Puts entries, one at least, at the end of a model, refits, and measures their ladder rows.
///
/// # Errors
/// When a fit fails.
pub fn put(
    experiment: &Experiment,
    model: &Model,
    entries: Vec<ModelEffect>,
    date: &str,
) -> Result<Step, AnalysisError> {
    Ok(put_on(&Problem::new(experiment, model)?, entries, date)?.0)
}

fn put_on<'a>(
    problem: &Problem<'a>,
    mut entries: Vec<ModelEffect>,
    date: &str,
) -> Result<(Step, Problem<'a>), AnalysisError> {
    let (experiment, before) = (problem.experiment(), problem.fit());
    let mut larger = problem.clone();
    for entry in &mut entries {
        let with = larger.with(std::slice::from_ref(entry))?;
        entry.ladder = Some(ladder_row(experiment, larger.fit(), with.fit(), date));
        larger = with;
    }
    let mut model = problem.model().clone();
    model.effects.extend(entries.iter().cloned());
    let mut entry = entries.first().cloned().unwrap_or_default();
    entry.ladder = Some(ladder_row(experiment, before, larger.fit(), date));
    let step = Step { entry, entries, model, before: before.clone(), identification: larger.fit().clone() };
    Ok((step, larger))
}

/// A model without one of its effects. The ladder rows of the effects after it are measured anew, because they said what
/// adding those did on top of the one that is gone.
///
/// # Errors
/// When the effect is not in the model or in every model, or a fit fails.
pub fn remove(experiment: &Experiment, model: &Model, id: &str, date: &str) -> Result<Model, AnalysisError> {
    if BASE.contains(&id) {
        return Err(AnalysisError::Base { id: id.into() });
    }
    let Some(at) = model.effects.iter().position(|entry| entry.id == id) else {
        let added: Vec<&str> =
            model.effects.iter().map(|e| e.id.as_str()).filter(|id| !BASE.contains(id)).collect();
        let held = if added.is_empty() { "nothing that was added".into() } else { added.join(", ") };
        return Err(AnalysisError::NotInModel { id: id.into(), held });
    };
    let mut smaller = model.clone();
    smaller.effects.remove(at);
    measure_ladder(experiment, &mut smaller, at, date)?;
    Ok(smaller)
}

/// Measures anew the ladder rows of the entries from `first` on, each on top of the entries before it.
fn measure_ladder(
    experiment: &Experiment,
    model: &mut Model,
    first: usize,
    date: &str,
) -> Result<(), AnalysisError> {
    let until =
        |last: usize| Model { machine: model.machine.clone(), effects: model.effects[..last].to_vec() };
    let mut rows = Vec::new();
    if first < model.effects.len() {
        let mut before = Problem::new(experiment, &until(first))?;
        for entry in &model.effects[first..] {
            let after = before.with(std::slice::from_ref(entry))?;
            rows.push(ladder_row(experiment, before.fit(), after.fit(), date));
            before = after;
        }
    }
    for (entry, row) in model.effects[first..].iter_mut().zip(rows) {
        if !BASE.contains(&entry.id.as_str()) {
            entry.ladder = Some(row);
        }
    }
    Ok(())
}

fn ladder_row(
    experiment: &Experiment,
    before: &Identification,
    after: &Identification,
    date: &str,
) -> LadderRow {
    let holdout_um = |fit: &Identification| fit.holdout_rms_mm().map(convert::um_from_mm);
    LadderRow {
        date: date.into(),
        run: experiment.runs.join(", "),
        error_before_um: convert::um_from_mm(before.rms_mm),
        error_after_um: convert::um_from_mm(after.rms_mm),
        holdout_before_um: holdout_um(before),
        holdout_after_um: holdout_um(after),
        holdout_unit: after.holdout.map(|holdout| holdout.left_out.name().into()),
        noise_um: after.repeatability.map(|noise| convert::um_from_mm(noise.sigma_mm)),
        moved: moved(before, after),
    }
}

/// A parameter counts as moved beyond this many standard uncertainties.
const MOVED_U: f64 = 2.0;

/// Parameters that moved by more than 2 u, most moved first; the location error that moved most is always among them.
fn moved(before: &Identification, after: &Identification) -> Vec<Moved> {
    let mut moved: Vec<(bool, Moved)> = Vec::new();
    for parameter in &before.parameters {
        let same = |p: &&FittedParameter| p.name == parameter.name && p.effect == parameter.effect;
        let Some(now) = after.parameters.iter().find(same) else { continue };
        let values = parameter.screen_value().zip(now.screen_value());
        // In units of what is known now: before, u held the missing effect as noise.
        if let (Some((before, after)), Some(u)) = (values, now.screen_u()) {
            let unit = now.unit.symbol.into();
            let one = Moved { name: now.name.clone(), before, after, u, unit };
            moved.push((now.effect == LOCATION_ERRORS, one));
        }
    }
    moved.sort_by(|a, b| b.1.in_u().total_cmp(&a.1.in_u()));
    let first_location = moved.iter().position(|(is_location, _)| *is_location);
    let keep = |at: usize, one: &Moved| Some(at) == first_location || one.in_u() > MOVED_U;
    moved.into_iter().enumerate().filter(|(at, (_, one))| keep(*at, one)).map(|(_, (_, one))| one).collect()
}

/// The model entries of an effect as a user names it. What a formula is not told is taken from what the diagnosis proposes
/// under the same name, with its further components.
///
/// # Errors
/// When the diagnosis fails or proposes no formula of this name.
pub fn entries(
    experiment: &Experiment,
    model: &Model,
    id: &str,
    told: &FormulaText,
) -> Result<Vec<ModelEffect>, AnalysisError> {
    let entry = entry(id, told)?;
    if is_complete(&entry) {
        return Ok(vec![entry]);
    }
    proposed(diagnose(experiment, model)?.formula, entry, told)
}

/// True for what can be added as it is.
fn is_complete(entry: &ModelEffect) -> bool {
    let described = entry.site.is_some() && entry.component.is_some() && entry.expression.is_some();
    Formula::name_of(&entry.id).is_none() || described
}

/// An effect as far as the user describes it.
fn entry(id: &str, told: &FormulaText) -> Result<ModelEffect, AnalysisError> {
    if Formula::name_of(id).is_none() && *told != FormulaText::default() {
        return Err(AnalysisError::NoFormula { id: id.into() });
    }
    Ok(ModelEffect {
        id: id.into(),
        site: told.site.clone(),
        component: told.component.clone(),
        expression: told.expression.clone(),
        grid: told.grid.clone(),
        ..ModelEffect::default()
    })
}

/// What is not told of a formula, from the one that a diagnosis proposes.
fn proposed(
    proposal: Option<FormulaProposal>,
    entry: ModelEffect,
    told: &FormulaText,
) -> Result<Vec<ModelEffect>, AnalysisError> {
    let name = Formula::name_of(&entry.id).unwrap_or_default();
    match proposal {
        Some(formula) if formula.name == name && *told == FormulaText::default() => Ok(formula.entries),
        Some(formula) if formula.name == name => Ok(vec![ModelEffect {
            site: entry.site.or(Some(formula.site)),
            component: entry.component.or(Some(formula.component)),
            shape: if entry.expression.is_none() && entry.grid.is_empty() {
                formula.shape.iter().map(|number| number.value).collect()
            } else {
                Vec::new()
            },
            expression: entry.expression.or(Some(formula.expression)),
            ..entry
        }]),
        other => Err(AnalysisError::NoSuchFormula {
            id: entry.id,
            proposed: other.map_or("none now".into(), |formula| Formula::id_of(&formula.name)),
        }),
    }
}
