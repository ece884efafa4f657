//! `trunnion ladder`: the effects added so far, with the error after each.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;
use trunnion_effects::LadderRow;
use trunnion_report::{ladder_html, ladder_text};

/// Show the effects added to a model, with the error after each
///
/// Example: trunnion ladder --model machine.model.toml --html ladder.html
#[derive(clap::Args)]
pub struct Args {
    /// Model file
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Write a self-contained page with the chart
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let model = load::model(&args.model)?;
    let ladder = trunnion::page::ladder(&model);
    if let Some(path) = &args.html {
        std::fs::write(path, ladder_html(&model.machine, &ladder))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
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
                        "holdout_unit": row.holdout_unit, "noise_um": row.noise_um, "moved": moved_json(row),
                    })
                });
                serde_json::json!({ "effect": entry.id, "ladder": ladder })
            })
            .collect();
        terminal::print_json(&serde_json::json!({ "format": "trunnion-ladder/1", "rows": rows }))?;
    } else {
        terminal::print(&ladder_text(&ladder, None))?;
        if let Some(path) = &args.html {
            terminal::print(&format!("page: {}\n", path.display()))?;
        }
    }
    Ok(Outcome::Done)
}

/// Parameters that moved when an effect came in.
pub fn moved_json(row: &LadderRow) -> Vec<serde_json::Value> {
    let moved = |m: &trunnion_effects::Moved| serde_json::json!({ "name": m.name, "before": m.before, "after": m.after, "u": m.u, "unit": m.unit });
    row.moved.iter().map(moved).collect()
}
