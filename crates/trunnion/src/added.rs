//! What was found before each effect of a model was added. The model file keeps who added it and why; the fits without and with it are
//! made again of the runs that are looked at.

use crate::{Error, Fit};
use trunnion_effects::catalogue::BASE;
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::spectrum::spectra;
use trunnion_results as results;

/// The fits without and with what each act added, on top of what was in the model before it; `now` is the diagnosis of the whole model.
pub(crate) fn trials(fit: &Fit, now: &results::Diagnosis) -> Result<Vec<results::Trial>, Error> {
    let model = fit.model().entries();
    let entries = &model.effects;
    let first = |count: usize| match count == entries.len() {
        true => Ok(fit.clone()),
        false => fit.experiment().fit(&Model::of(&model.machine, entries[..count].to_vec()).into()),
    };
    let mut trials = Vec::new();
    let (mut count, mut before) = (0, None);
    for act in entries.chunk_by(|one, next| one.added_as() == next.added_as()) {
        let begin = count;
        count += act.len();
        let was_added = act[0].ladder.is_some() && !BASE.contains(&act[0].id.as_str());
        if !was_added {
            continue;
        }
        let (without, with) = (before.take().map_or_else(|| first(begin), Ok)?, first(count)?);
        let then = Some(now).filter(|_| count == entries.len());
        trials.push(trial(&act[0], act, [&without, &with], then));
        before = Some(with);
    }
    Ok(trials)
}

/// What a fit leaves along each axis, by period.
pub(crate) fn spectra_of(fit: &Fit) -> Vec<results::AxisSpectrum> {
    spectra(&fit.problem()).iter().flatten().map(results::AxisSpectrum::from).collect()
}

/// The fits without and with what was added; `then` is the diagnosis of the model with it.
pub(crate) fn trial(
    whole: &ModelEffect,
    entries: &[ModelEffect],
    fits: [&Fit; 2],
    then: Option<&results::Diagnosis>,
) -> results::Trial {
    let points = fits[1].experiment().points();
    let mut answer = results::Trial::new(points, whole, entries, fits.map(Fit::identification), then);
    let [before, after] = fits.map(spectra_of);
    answer.spectra = results::SpectraBeforeAfter { before, after };
    answer.identification.doubts = fits[1].doubts();
    answer
}
