//! `trunnion diagnose`: which physical effect is missing from the model.

use crate::load::{ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use trunnion::analysis;
use trunnion_report::diagnosis_text;

/// Say which physical effect is missing from the model
///
/// Where the data do not tell effects apart, it plans the cycle that would; `trunnion plan` writes that cycle's file.
///
/// Example: trunnion diagnose run.mcap --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Print JSON (format trunnion-diagnosis/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let load::Loaded { runs, outcome, .. } = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    let diagnosis = analysis::diagnose_and_plan(&experiment, &model)?;
    if args.json {
        terminal::print_json(&diagnosis.to_json())?;
    } else {
        terminal::print(&diagnosis_text(&diagnosis))?;
    }
    Ok(outcome)
}
