//! What one run shows, as a history lists it; worked out by whoever analyses the run first.

use super::Keeper;
use super::keeper::Place;
use crate::{Diagnosed, Error, Model};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use trunnion_results::sentences::{is_setting, not_plausible};
use trunnion_results::{Diagnosis, HistoryRun, Parameter, Verdict};

const KIND: &str = "run";

/// What one run shows by a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Found {
    /// Ids of the effects that were fitted.
    pub(super) effects: Vec<String>,
    /// Without its name and its moment.
    pub(super) run: HistoryRun,
}

/// What the run of these files shows; `worked_out` gets the analysis where nothing was kept.
pub(super) fn found(
    files: &[PathBuf],
    name: &str,
    model: Option<&Model>,
    keeper: &mut Keeper<'_>,
    worked_out: &mut Option<Diagnosed>,
) -> Result<Found, Error> {
    keeper.answer((KIND, name), &[files.to_vec()], model, || {
        let diagnosed = worked_out.insert(diagnosed(files, model)?);
        Ok(of(diagnosed))
    })
}

pub(super) fn diagnosed(files: &[PathBuf], model: Option<&Model>) -> Result<Diagnosed, Error> {
    let experiment = crate::open_runs(&[files.to_vec()])?;
    let base = experiment.base_model();
    let fit = experiment.fit_within_reach(model.unwrap_or(&base))?;
    Diagnosed::without_plan(&fit)
}

fn of(diagnosed: &Diagnosed) -> Found {
    let (fit, diagnosis) = (diagnosed.fit().results(), diagnosed.results());
    let judged = diagnosis.verdict != Verdict::NotJudged;
    let of_machine = |p: &Parameter| judged && p.value.is_some() && p.u.is_some() && !is_setting(&p.effect);
    let run = HistoryRun {
        verdict: diagnosis.verdict,
        candidate: Diagnosis::named_in_short(&diagnosis.named()),
        rms_um: Some(fit.rms_um).filter(|_| judged),
        temperature_degc: diagnosed.fit().experiment().temperature_degc(),
        values: fit.listed().into_iter().filter(of_machine).collect(),
        trouble: not_plausible(&fit.plausibility),
        losses: diagnosed.fit().experiment().losses(),
        ..HistoryRun::default()
    };
    let effects = diagnosed.fit().model().effects().into_iter().map(str::to_owned).collect();
    Found { effects, run }
}

/// Where a history looks for what a run shows, as its files are now.
pub struct Filed(Option<Place>);

/// Where a history looks for what the run of these files shows by this model. Asked before they are analysed.
pub fn filed(files: &[PathBuf], model: Option<&Model>) -> Filed {
    Filed(Keeper::default().place(KIND, &[files.to_vec()], model))
}

impl Filed {
    /// Keeps what an analysis of these files by this model found, where a history would find the same.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, diagnosed: &Diagnosed) -> Result<(), Error> {
        let fit = diagnosed.fit();
        // A diagnosis that failed may not fail again, and a history leaves out what is out of reach.
        let failed =
            diagnosed.results().verdict == Verdict::NotJudged && fit.experiment().plausibility().is_empty();
        let whole = fit.experiment().within_reach(fit.model()).effects.len() == fit.model().effects().len();
        match &self.0 {
            Some(place) if whole && !failed => place.write(&of(diagnosed)),
            _ => Ok(()),
        }
    }
}
