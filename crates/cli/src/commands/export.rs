//! `trunnion export`: the points of a recording as a table, its samples, residuals or parameters; of many as one.

use crate::load::ModelArgs;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::bail;
use std::path::{Path, PathBuf};
use trunnion::report::{parameters_csv, residuals_csv, run_csv};
use trunnion::tables::parquet::Rows;
use trunnion::tables::{Exported, by_effect_csv, export};

/// Export recordings as a table
///
/// points: the good points, as `import` reads them. every-point: unsettled points and those without a reading too, with a column
/// `quality`. samples: what each probe sent, with raw numbers and ticks. axes: positions of the axes. residuals: measured, predicted
/// and residual reading of every pose, as --model fits it. effects: what each effect of the model makes of each reading; effects
/// that are confounded in the run are one. parameters: what that fit found. runs: the fit in one row.
///
/// Parquet takes many recordings in one table, with machine, serial number, run and its beginning in front.
///
/// Example: trunnion export csv run.mcap -o points.csv
///
/// Example: trunnion export parquet runs/*.mcap --what parameters -o parameters.parquet
#[derive(clap::Args)]
pub struct Args {
    /// What to write
    #[arg(value_parser = ["csv", "parquet"])]
    format: String,
    /// Recordings; one for csv
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// Part of the recording
    #[arg(long, value_name = "PART", default_value = "points", value_parser = parts())]
    what: String,
    #[command(flatten)]
    model: ModelArgs,
    /// File to write; without it, standard output (csv)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// The parts that are computed, not recorded.
const COMPUTED: [&str; 4] = ["residuals", "effects", "parameters", "runs"];

fn parts() -> Vec<&'static str> {
    Exported::NAMES.into_iter().map(|(name, _)| name).chain(COMPUTED).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    for run in &args.runs {
        load::no_points_file(run)?;
    }
    match (&args.output, &args.runs[..]) {
        (Some(path), runs) if args.format == "parquet" => parquet(args, runs, path),
        (None, _) if args.format == "parquet" => bail!("parquet is no text; name the file with -o FILE"),
        (_, [run]) => {
            let (table, outcome) = table(args, run)?;
            match &args.output {
                None => terminal::print_verbatim(&table)?,
                Some(path) => output::write(path, &table)?,
            }
            Ok(outcome)
        }
        (_, runs) => {
            bail!("csv is a table of one recording, and {} are named; parquet takes many", runs.len())
        }
    }
}

/// The table of one recording.
fn table(args: &Args, run: &Path) -> anyhow::Result<(String, Outcome)> {
    if let Some((_, what)) = Exported::NAMES.into_iter().find(|(name, _)| *name == args.what) {
        let (table, damage) = export(run, what)?;
        return Ok((table, load::outcome(damage)));
    }
    let loaded = load::runs(&load::RunArgs::of(vec![run.into()]))?;
    let fit = loaded.experiment.fit(&args.model.model(&loaded.experiment)?)?;
    let table = match args.what.as_str() {
        "parameters" => parameters_csv(&fit.results()),
        "runs" => run_csv(&fit.results()),
        "effects" => by_effect_csv(&fit),
        _ => residuals_csv(&fit.residuals()),
    };
    Ok((table, loaded.stated_judgement()))
}

fn parquet(args: &Args, runs: &[PathBuf], path: &Path) -> anyhow::Result<Outcome> {
    let (mut rows, mut outcome) = (Rows::begin()?, Outcome::Done);
    for run in runs {
        let added =
            table(args, run).and_then(|(table, of_run)| Ok(rows.add(run, &table).map(|()| of_run)?));
        // One bad recording of a thousand costs itself alone.
        let of_run = added.unwrap_or_else(|failure| {
            terminal::remark(&format!("left out: {}: {failure:#}", run.display()));
            Outcome::DataLoss
        });
        outcome = if of_run == Outcome::Done { outcome } else { of_run };
    }
    rows.write(path)?;
    terminal::print(&format!("{} rows of {} recordings: {}\n", rows.count(), runs.len(), path.display()))?;
    Ok(outcome)
}
