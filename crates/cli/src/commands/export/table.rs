//! The table of one recording.

use crate::load::{self, ModelArgs};
use crate::outcome::Outcome;
use std::path::Path;
use trunnion::report::{parameters_csv, residuals_csv, run_csv};
use trunnion::tables::{Exported, by_effect_csv, export};

/// The parts that are computed, not recorded.
const COMPUTED: [&str; 4] = ["residuals", "effects", "parameters", "runs"];

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
    let loaded = load::runs(&load::RunArgs::of(vec![run.into()]))?;
    let fit = loaded.experiment.fit(&model.stated_model(&loaded.experiment)?)?;
    let table = match part {
        "parameters" => parameters_csv(&fit.results()),
        "runs" => run_csv(&fit.results()),
        "effects" => by_effect_csv(&fit),
        _ => residuals_csv(&fit.residuals()),
    };
    Ok((table, loaded.stated_judgement()))
}
