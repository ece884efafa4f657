//! `trunnion predict`: a model against runs that it was not fitted to.

use crate::load::RunArgs;
use crate::outcome::Outcome;
use crate::{load, terminal};
use std::path::PathBuf;
use trunnion::Model;

/// Predict runs with values fitted to others: error, and share of the readings inside the 95 % band
///
/// The values are those that the model file keeps since the last `add` or `identify --keep`; with --fitted the model is fitted
/// to those recordings first, and the file stays as it is. Everything of the machine is frozen; only how the ball was set is
/// fitted to each new run.
///
/// Example: trunnion predict wednesday.mcap --model machine.model.toml
///
/// Example: trunnion predict friday.mcap --fitted tuesday.mcap wednesday.mcap --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    /// Recordings that the model is fitted to, instead of the values that its file keeps
    #[arg(long, value_name = "RUN", num_args = 1..)]
    fitted: Vec<PathBuf>,
    /// Model file
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Print JSON (format trunnion-prediction/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let model = Model::load(&args.model)?;
    let loaded = load::runs(&args.runs)?;
    let (outcome, other) = (loaded.stated_judgement(), loaded.experiment);
    let (prediction, of_fitted) = if args.fitted.is_empty() {
        (model.predict(&other)?, Outcome::Done)
    } else {
        let loaded = load::runs(&RunArgs::of(args.fitted.clone()))?;
        let outcome = loaded.stated_judgement();
        (loaded.experiment.fit(&model)?.predict(&other)?, outcome)
    };
    if args.json {
        terminal::print_json(&prediction)?;
    } else {
        let values = if args.fitted.is_empty() { "that it keeps" } else { "fitted to the runs of --fitted" };
        let of = format!("Effects of {}, values {values}.", args.model.display());
        terminal::print(&format!("{of}\n{}", trunnion::report::prediction_text(&prediction)))?;
    }
    Ok(if of_fitted == Outcome::Done { outcome } else { of_fitted })
}
