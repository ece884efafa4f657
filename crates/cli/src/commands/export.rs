//! `trunnion export`: the points of a recording as a table.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;

/// Export a recording as a table
///
/// Example: trunnion export csv run.mcap -o points.csv
#[derive(clap::Args)]
pub struct Args {
    /// What to write
    #[arg(value_parser = ["csv"])]
    format: String,
    /// Recording
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// File to write; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    load::no_points_file(&args.run)?;
    let (table, damage) = trunnion::tables::export_csv(&args.run)?;
    let outcome = load::outcome(damage);
    match &args.output {
        None => terminal::print(&table)?,
        Some(path) => {
            std::fs::write(path, table).with_context(|| format!("cannot write {}", path.display()))?
        }
    }
    Ok(outcome)
}
