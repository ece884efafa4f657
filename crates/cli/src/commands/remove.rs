//! `trunnion remove`: take an effect out of the model again, and measure the ladder rows after it anew.

use crate::commands::add::today;
use crate::load::RunArgs;
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;
use trunnion::{analysis, page};
use trunnion_effects::Model;
use trunnion_engine::Experiment;

/// Take an effect out of the model, refit, and measure the ladder rows after it anew
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
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let text = load::read(&args.model)?;
    let model = Model::parse(&args.model.display().to_string(), &text)?;
    let load::Loaded { runs, outcome, .. } = load::runs(&args.runs)?;
    let experiment = Experiment::new(&runs)?;
    let smaller = analysis::remove(&experiment, &model, &args.effect, &today()?)?;
    let mut shorter = Model::without(&text, &args.effect)?;
    for entry in &smaller.effects {
        let unchanged = model.effects.iter().any(|old| old.id == entry.id && old.ladder == entry.ladder);
        if let Some(row) = entry.ladder.as_ref().filter(|_| !unchanged) {
            shorter = Model::with_ladder_row(&shorter, &entry.id, row)?;
        }
    }
    let fit = trunnion_engine::identify(&experiment, &smaller, &trunnion_engine::fit::Options::default())?;
    std::fs::write(&args.model, shorter).with_context(|| format!("cannot write {}", args.model.display()))?;
    if args.json {
        terminal::print_json(&serde_json::json!({
            "removed": args.effect, "model": args.model.display().to_string(),
            "effects": smaller.effects.iter().map(|entry| entry.id.as_str()).collect::<Vec<_>>(),
            "identification": fit.to_json(),
        }))?;
    } else {
        terminal::print(&format!("{} is out of {}\n\n", args.effect, args.model.display()))?;
        let noise_um = fit.repeatability.map(|noise| trunnion_core::convert::um_from_mm(noise.sigma_mm));
        terminal::print(&trunnion_report::ladder_text(&page::ladder(&smaller), noise_um))?;
        terminal::print("\n")?;
        terminal::print(&trunnion_report::identification_text(&(&fit).into()))?;
    }
    Ok(outcome)
}
