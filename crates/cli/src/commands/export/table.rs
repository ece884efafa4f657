//! The table of one recording.

use crate::load::{self, ModelArgs};
use crate::outcome::Outcome;
use std::path::Path;
use trunnion::report::{parameters_csv, residuals_csv, run_csv};
use trunnion::results::RunResult;
use trunnion::tables::{Exported, by_effect_csv, export};
use trunnion_service::page::own_model;
use trunnion_service::run_record;

/// The parts that are computed, not recorded.
const COMPUTED: [&str; 4] = ["residuals", "effects", "parameters", RUNS];
const RUNS: &str = "runs";

pub fn parts() -> Vec<&'static str> {
    Exported::NAMES.into_iter().map(|(name, _)| name).chain(COMPUTED).collect()
}

pub fn of(run: &Path, what: Option<&str>, model: &ModelArgs) -> anyhow::Result<(String, Outcome)> {
    let [(usual, _), ..] = Exported::NAMES;
    let part = what.unwrap_or(usual);
    if let Some((_, what)) = Exported::NAMES.into_iter().find(|(name, _)| *name == part) {
        let (table, missing) = export(run, what)?;
        return Ok((table, load::outcome(&missing)));
    }
    let is_found = part == RUNS && model.model.is_none();
    let (model, kept) = if is_found { found(run) } else { (model.clone(), None) };
    let loaded = load::runs(&load::RunArgs::of(vec![run.into()]))?;
    let fit = loaded.experiment.fit(&model.stated_model(&loaded.experiment)?)?;
    let table = match part {
        "parameters" => parameters_csv(&fit.results()),
        RUNS => run_csv(&fit.results(), kept.as_ref()),
        "effects" => by_effect_csv(&fit),
        _ => residuals_csv(&fit.residuals()),
    };
    Ok((table, loaded.stated_judgement()))
}

/// What a run was found to have: its own model file, to which a person added effects, and the answer that is kept of it.
fn found(run: &Path) -> (ModelArgs, Option<RunResult>) {
    let own = Some(own_model(run)).filter(|own| own.exists());
    let kept = run_record::read(run).and_then(|record| record.answer);
    (ModelArgs { model: own }, kept.map(|answer| answer.result))
}
