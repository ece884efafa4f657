//! `trunnion diagnose`: which physical effect is missing from the model.

use crate::load::{Loaded, ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};

/// Say which physical effect is missing from the model
///
/// Where the data do not separate effects, it plans the cycle that would; `trunnion plan` writes that cycle's file.
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
    let Loaded { experiment, outcome } = load::runs(&args.runs)?;
    let answer = experiment.fit(&args.model.model(&experiment)?)?.diagnose()?;
    if args.json {
        terminal::print_json(&answer.results())?;
    } else {
        terminal::print(&answer.summary())?;
    }
    Ok(outcome.with_verdict(answer.results().verdict))
}
