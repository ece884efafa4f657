//! `trunnion identify`: the machine's errors with uncertainties, and what cannot be seen.

use crate::load::{self, ModelArgs, RunArgs};
use crate::outcome::{self, Outcome};
use trunnion_report::identification_text;

/// Identify the machine's errors from recordings
///
/// Example: trunnion identify run.mcap --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Print JSON (format trunnion-identification/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let (runs, outcome) = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    let identification =
        trunnion_identify::identify(&experiment, &model, &trunnion_identify::Options::default())?;
    if args.json {
        outcome::print_json(&identification.to_json())?;
    } else {
        outcome::print(&identification_text(&(&identification).into()))?;
    }
    Ok(outcome)
}
