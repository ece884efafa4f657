//! `trunnion export`: the points of a recording as a table.

use crate::outcome::Outcome;
use crate::{load, output, terminal};
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
        None => terminal::print_verbatim(&table)?,
        Some(path) => output::write(path, &table)?,
    }
    Ok(outcome)
}
