//! `trunnion add`: put an effect into the model, refit, append the ladder row.

use crate::load::{self, RunArgs};
use crate::outcome::{self, Outcome};
use anyhow::{Context, bail};
use std::path::PathBuf;
use trunnion_effects::Model;
use trunnion_identify::Experiment;

/// Add an effect to the model, refit, and show how far the error falls
///
/// Example: trunnion add gravity-sag:B run.mcap --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    /// Effect id, e.g. gravity-sag:B, or the formula that `diagnose` proposed, formula:NAME
    effect: String,
    #[command(flatten)]
    runs: RunArgs,
    /// Model file; made from the base model when it does not exist yet
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let (runs, outcome) = load::runs(&args.runs)?;
    let experiment = Experiment::new(&runs)?;
    let text = if args.model.exists() {
        load::read(&args.model)?
    } else {
        Model::base(&experiment.machine().name).to_text()
    };
    let model = Model::parse(&args.model.display().to_string(), &text)?;
    if model.effects.iter().any(|entry| entry.id == args.effect) {
        bail!(
            "{} is in {} already; remove its [[effect]] entry to add it anew",
            args.effect,
            args.model.display()
        );
    }
    let step = trunnion_daemon::analysis::add(&experiment, &model, &args.effect, &today()?)?;
    std::fs::write(&args.model, Model::append(&text, &step.entry)?)
        .with_context(|| format!("cannot write {}", args.model.display()))?;
    let row = step.entry.ladder.as_ref().context("an added effect has a ladder row")?;
    if args.json {
        outcome::print_json(&serde_json::json!({
            "effect": args.effect, "model": args.model.display().to_string(),
            "error_before_um": row.error_before_um, "error_after_um": row.error_after_um,
            "holdout_before_um": row.holdout_before_um, "holdout_after_um": row.holdout_after_um,
            "noise_um": row.noise_um, "identification": step.identification.to_json(),
        }))?;
    } else {
        outcome::print(&trunnion_report::ladder_text(
            &trunnion_daemon::page::ladder(&step.model),
            Some(row.noise_um),
        ))?;
        outcome::print(&trunnion_report::identification_text(&(&step.identification).into()))?;
    }
    Ok(outcome)
}

/// Today's date, UTC, as `YYYY-MM-DD`.
fn today() -> anyhow::Result<String> {
    let since_1970 = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .context("the clock is before 1970")?;
    let stamp = trunnion_protocol::mtconnect::format_timestamp(i64::try_from(since_1970.as_nanos())?);
    Ok(stamp.chars().take(10).collect())
}
