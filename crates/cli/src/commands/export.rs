//! `trunnion export`: the points of a recording as a table, its samples, or its residuals.

use crate::load::ModelArgs;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use std::path::PathBuf;
use trunnion::report::residuals_csv;
use trunnion::results::Comparison;
use trunnion::tables::{Exported, export};

/// Export a recording as a table
///
/// points: the good points, as `import` reads them. every-point: unsettled points and those without a reading too, with a column
/// `quality`. samples: what each probe sent, with raw numbers and ticks. axes: positions of the axes. residuals: measured, predicted
/// and residual reading of every pose, as --model fits it.
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
    /// Part of the recording
    #[arg(long, value_name = "PART", default_value = "points", value_parser = parts())]
    what: String,
    #[command(flatten)]
    model: ModelArgs,
    /// File to write; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The part that is computed, not recorded.
const RESIDUALS: &str = "residuals";

fn parts() -> Vec<&'static str> {
    Exported::NAMES.into_iter().map(|(name, _)| name).chain([RESIDUALS]).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    load::no_points_file(&args.run)?;
    let recorded = Exported::NAMES.into_iter().find(|(name, _)| *name == args.what);
    let (table, outcome) = match recorded {
        Some((_, what)) => {
            let (table, damage) = export(&args.run, what)?;
            (table, load::outcome(damage))
        }
        None => residuals(args)?,
    };
    match &args.output {
        None => terminal::print_verbatim(&table)?,
        Some(path) => output::write(path, &table)?,
    }
    Ok(outcome)
}

fn residuals(args: &Args) -> anyhow::Result<(String, Outcome)> {
    let loaded = load::runs(&load::RunArgs::of(vec![args.run.clone()]))?;
    let fit = loaded.experiment.fit(&args.model.model(&loaded.experiment)?)?;
    let residuals = Comparison::new(loaded.experiment.points(), fit.identification(), None).residuals;
    Ok((residuals_csv(&residuals), loaded.stated_judgement()))
}
