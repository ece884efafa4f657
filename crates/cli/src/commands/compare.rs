//! `trunnion compare`: where does the model fail.

use crate::load::{self, ModelArgs, RunArgs};
use crate::outcome::{self, Outcome};
use anyhow::Context;
use std::path::PathBuf;
use trunnion_daemon::{analysis, page};
use trunnion_report::{compare_html, compare_text};

/// Show where the model fails: tables, and a page with plots
///
/// Example: trunnion compare run.mcap --model machine.model.toml --html report.html
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Write a self-contained page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let (runs, outcome) = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    let fit = trunnion_identify::identify(&experiment, &model, &trunnion_identify::Options::default())?;
    let diagnosis = analysis::diagnose(&experiment, &model)?;
    let input = page::compare_input(&experiment, &fit, Some(&diagnosis), &model, &[]);
    if let Some(path) = &args.html {
        std::fs::write(path, compare_html(&input))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        outcome::print_json(&serde_json::json!({
            "format": "trunnion-comparison/1",
            "identification": fit.to_json(),
            "diagnosis": diagnosis.to_json(),
            "html": args.html.as_ref().map(|path| path.display().to_string()),
        }))?;
    } else {
        outcome::print(&compare_text(&input))?;
        if let Some(path) = &args.html {
            outcome::print(&format!("page: {}\n", path.display()))?;
        }
    }
    Ok(outcome)
}
