//! `trunnion remove`: take an effect out of the model, and measure the later rows of the ladder again.

use crate::commands::add::today;
use crate::load::RunArgs;
use crate::outcome::Outcome;
use crate::{load, terminal};
use std::path::PathBuf;
use trunnion::Model;
use trunnion::report::ladder_text;
use trunnion::results::Removed;

/// Take an effect out of the model, refit, and measure the later rows of the ladder again
///
/// An expression of several components came in by one act, as an entry for each, and goes out the same way.
///
/// Example: trunnion remove gravity-sag:B run.mcap --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    /// Effect id as in the model file
    effect: String,
    #[command(flatten)]
    runs: RunArgs,
    /// Model file; everything but the effect and the ladder rows after it stays as it is written
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Who removes it; kept in the model file
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let model = Model::load(&args.model)?;
    let loaded = load::runs(&args.runs)?;
    let (outcome, experiment) = (loaded.judgement(), loaded.experiment);
    let held = model.effects();
    let without = experiment.fit(&model)?.remove(&args.effect, &today()?, args.by.as_deref())?;
    without.model().save(&args.model)?;
    if args.json {
        terminal::print_json(&Removed {
            removed: args.effect.clone(),
            model: args.model.display().to_string(),
            effects: without.model().effects().into_iter().map(String::from).collect(),
            identification: without.results(),
        })?;
    } else {
        let kept = without.model().effects();
        let gone: Vec<&str> = held.into_iter().filter(|id| !kept.contains(id)).collect();
        let (gone, are) = (gone.join(" and "), if gone.len() > 1 { "are" } else { "is" });
        terminal::print(&format!("{gone} {are} out of {}\n\n", args.model.display()))?;
        terminal::print(&ladder_text(&without.model().ladder(), without.results().noise_um))?;
        terminal::print("\n")?;
        terminal::print(&without.summary())?;
    }
    Ok(outcome)
}
