//! Effects put into a model and taken out of it, with what that does to the error.

use crate::analysis_error::AnalysisError;
use trunnion_core::{convert, names};
use trunnion_effects::catalogue::{BASE, LOCATION_ERRORS};
use trunnion_effects::{Formula, LadderRow, Model, ModelEffect, Moved};
use trunnion_engine::{
    DiagnoseError, Diagnosis, Experiment, FittedParameter, FormulaProposal, Identification, Problem,
    diagnose_problem,
};

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

/// Effects put at the end of a model.
pub(crate) struct Put {
    /// What was added, with the ladder row of all of it.
    pub whole: ModelEffect,
    /// The new entries: a formula of several components is one entry for each. The row of the first is that of all of them, the others
    /// name it.
    pub entries: Vec<ModelEffect>,
    /// The fit of the model with them.
    pub fit: Identification,
}

/// Puts entries, one at least, at the end of a model, fits again, and measures their ladder rows.
pub(crate) fn put(
    problem: &Problem<'_>,
    mut entries: Vec<ModelEffect>,
    date: &str,
) -> Result<Put, AnalysisError> {
    let experiment = problem.experiment();
    let larger = measure_act(experiment, problem, &mut entries, date)?;
    let whole = entries.first().cloned().unwrap_or_default();
    Ok(Put { whole, entries, fit: larger.into_fit() })
}

/// Measures the rows of what one act adds: of the first entry that of all, of each further one its own on top of those before it.
fn measure_act<'a>(
    experiment: &Experiment,
    before: &Problem<'a>,
    entries: &mut [ModelEffect],
    date: &str,
) -> Result<Problem<'a>, AnalysisError> {
    let first = entries.first().map(|entry| entry.id.clone());
    let mut larger = before.clone();
    for (i, entry) in entries.iter_mut().enumerate() {
        let with = larger.with(std::slice::from_ref(entry))?;
        let was = entry.ladder.take().unwrap_or_default();
        let lead = first.clone().filter(|_| i > 0);
        let row = ladder_row(experiment, larger.fit(), with.fit(), date).again(was);
        entry.ladder = Some(LadderRow { with: lead, ..row });
        larger = with;
    }
    if let [first, _, ..] = entries {
        let was = first.ladder.take().unwrap_or_default();
        first.ladder = Some(ladder_row(experiment, before.fit(), larger.fit(), date).again(was));
    }
    Ok(larger)
}

/// A model without one of its effects, and without what came in with it by one act. The ladder rows of the effects after it are measured again, because they said what
/// adding those did on top of the one that is gone; what a diagnosis said for them is kept, with the name of that one.
///
/// # Errors
/// When the effect is not in the model or in every model, or a fit fails.
pub(crate) fn remove(
    experiment: &crate::Experiment,
    model: &Model,
    id: &str,
    date: &str,
) -> Result<(Model, Identification), AnalysisError> {
    if BASE.contains(&id) {
        return Err(AnalysisError::Base { id: id.into() });
    }
    let Some(at) = model.effects.iter().position(|entry| entry.id == id) else {
        let added: Vec<&str> =
            model.effects.iter().map(|e| e.id.as_str()).filter(|id| !BASE.contains(id)).collect();
        let held = if added.is_empty() { "nothing that was added".into() } else { names::allowed(id, added) };
        return Err(AnalysisError::NotInModel { id: id.into(), held });
    };
    let act = model.effects[at].added_as();
    let first = model.effects.iter().position(|entry| entry.added_as() == act).unwrap_or(at);
    let mut smaller = model.clone();
    smaller.effects.retain(|entry| entry.added_as() != act);
    let rows = smaller.effects[first..].iter_mut().filter_map(|entry| entry.ladder.as_mut());
    rows.filter(|row| row.was_found()).for_each(|row| row.found_with.push(act.into()));
    let fit = measure_ladder(experiment, &mut smaller, first, date)?;
    Ok((smaller, fit))
}

/// Measures again the ladder rows of the entries from `first` on, each act on top of the entries before it; gives the fit of all.
fn measure_ladder(
    experiment: &crate::Experiment,
    model: &mut Model,
    first: usize,
    date: &str,
) -> Result<Identification, AnalysisError> {
    let shorter = Model::of(&model.machine, model.effects[..first].to_vec());
    let points = experiment.points();
    let mut before = Problem::known(points, &shorter, experiment)?;
    for act in model.effects[first..].chunk_by_mut(|one, next| one.added_as() == next.added_as()) {
        before = if BASE.contains(&act[0].id.as_str()) {
            before.with(act)?
        } else {
            measure_act(points, &before, act, date)?
        };
    }
    Ok(before.into_fit())
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
        by: None,
        with: None,
        run: experiment.runs.join(", "),
        error_before_um: convert::um_from_mm(before.rms_mm),
        error_after_um: convert::um_from_mm(after.rms_mm),
        holdout_before_um: holdout_um(before),
        holdout_after_um: holdout_um(after),
        holdout_unit: after.holdout.map(|holdout| holdout.left_out.name().into()),
        noise_um: after.repeatability.map(|noise| convert::um_from_mm(noise.sigma_mm)),
        moved: moved(before, after),
        ..LadderRow::default()
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
        // `p1` of one expression is not that of another.
        let is_shared = after.parameters.iter().filter(|p| p.name == now.name).count() > 1;
        let name = if is_shared { format!("{} of {}", now.name, now.effect) } else { now.name.clone() };
        let values = parameter.screen_value().zip(now.screen_value());
        // In units of what is known now: before, u held the missing effect as noise.
        if let (Some((before, after)), Some(u)) = (values, now.screen_u()) {
            let unit = now.unit.symbol.into();
            let one = Moved { name, before, after, u, unit };
            moved.push((now.effect == LOCATION_ERRORS, one));
        }
    }
    moved.sort_by(|a, b| b.1.in_u().total_cmp(&a.1.in_u()));
    let first_location = moved.iter().position(|(is_location, _)| *is_location);
    let keep = |at: usize, one: &Moved| Some(at) == first_location || one.in_u() > MOVED_U;
    moved.into_iter().enumerate().filter(|(at, (_, one))| keep(*at, one)).map(|(_, (_, one))| one).collect()
}

/// The model entries of an effect as a user names it. What a formula lacks is taken from what the diagnosis proposes
/// under the same name, with its further components.
///
/// # Errors
/// When the diagnosis fails or proposes no formula of this name.
pub(crate) fn entries(
    experiment: &crate::Experiment,
    problem: &Problem<'_>,
    id: &str,
    text: &FormulaText,
) -> Result<Vec<ModelEffect>, AnalysisError> {
    let entry = entry(id, text)?;
    if is_complete(&entry) {
        return Ok(vec![entry]);
    }
    proposed(diagnosed(experiment, problem)?.formula, entry, text)
}

/// A diagnosis with the default options.
pub(crate) fn diagnosed(
    experiment: &crate::Experiment,
    problem: &Problem<'_>,
) -> Result<Diagnosis, DiagnoseError> {
    let work = || diagnose_problem(problem, &trunnion_engine::diagnosis::Options::default());
    experiment.kept().answer("diagnosis", (problem.model(), &()), work)
}

/// True for what can be added as it is.
fn is_complete(entry: &ModelEffect) -> bool {
    let described = entry.site.is_some() && entry.component.is_some() && entry.expression.is_some();
    Formula::name_of(&entry.id).is_none() || described
}

/// An effect as far as the user describes it.
fn entry(id: &str, text: &FormulaText) -> Result<ModelEffect, AnalysisError> {
    if Formula::name_of(id).is_none() && *text != FormulaText::default() {
        return Err(AnalysisError::NoFormula { id: id.into() });
    }
    Ok(ModelEffect {
        id: id.into(),
        site: text.site.clone(),
        component: text.component.clone(),
        expression: text.expression.clone(),
        grid: text.grid.clone(),
        ..ModelEffect::default()
    })
}

/// What a formula lacks, from the one that a diagnosis proposes.
fn proposed(
    proposal: Option<FormulaProposal>,
    entry: ModelEffect,
    text: &FormulaText,
) -> Result<Vec<ModelEffect>, AnalysisError> {
    let name = Formula::name_of(&entry.id).unwrap_or_default();
    match proposal {
        Some(formula) if formula.name == name && *text == FormulaText::default() => Ok(formula.entries),
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
