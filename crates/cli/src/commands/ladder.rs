//! `trunnion ladder`: the effects added so far, with the error after each.

use crate::load;
use crate::outcome::{self, Outcome};
use std::path::PathBuf;

/// Show the effects added to a model, with the error after each
///
/// Example: trunnion ladder --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    /// Model file
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let model = load::model(&args.model)?;
    if args.json {
        let rows: Vec<_> = model
            .effects
            .iter()
            .map(|entry| {
                let ladder = entry.ladder.as_ref().map(|row| {
                    serde_json::json!({
                        "date": row.date, "run": row.run,
                        "error_before_um": row.error_before_um, "error_after_um": row.error_after_um,
                        "holdout_before_um": row.holdout_before_um, "holdout_after_um": row.holdout_after_um,
                        "noise_um": row.noise_um,
                    })
                });
                serde_json::json!({ "effect": entry.id, "ladder": ladder })
            })
            .collect();
        outcome::print_json(&serde_json::json!({ "format": "trunnion-ladder/1", "rows": rows }))?;
    } else {
        outcome::print(&trunnion_report::ladder_text(
            &trunnion_daemon::page::ladder(&model),
            model.effects.iter().rev().find_map(|e| Some(e.ladder.as_ref()?.noise_um)),
        ))?;
    }
    Ok(Outcome::Done)
}
