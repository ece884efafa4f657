//! `trunnion volumetric`: how far tool and table are off all over a volume, by a fitted model.

use crate::load::{ModelArgs, RunArgs};
use crate::one_of::one_of;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use std::path::PathBuf;
use trunnion::Datum;

/// Volumetric accuracy and error map of a volume, by a model fitted to recordings
///
/// The largest range of the deviation of tool against table over the volume (ISO 230-1): position in X, Y, Z and
/// orientation in A, B, C, with uncertainties. What these recordings do not show is named and left out
/// (docs/use/volumetric.md).
///
/// Example: trunnion volumetric tracker.mcap --model volume.toml --volume "X=-200..200,Y=-200..200" --csv map.csv
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Ranges in mm and degrees, e.g. "X=-200..200,Z=0..300,B=-90..90,C=30"; what is not named is at its measured range (linear axes) or at zero (rotary axes)
    #[arg(long, value_name = "RANGES", default_value = "", allow_hyphen_values = true)]
    volume: String,
    /// Places along each axis that moves; without it as many as the waves of the model need, seven or more where there may be so many
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=101))]
    steps: Option<u16>,
    /// Point of the tool to look at, tool axes, mm: 0,0,-100 is the tip of a tool 100 mm longer than the machine file's tool point
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,0", allow_hyphen_values = true, value_parser = point)]
    tool_point: Point,
    /// Coordinate system: fit removes the rigid displacement that fits the whole volume best, model keeps that of the model
    #[arg(long, value_name = "NAME", default_value = "fit", value_parser = datum)]
    datum: Datum,
    /// Page with the distorted volume
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Error map: positions, deviations, standard uncertainties
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print JSON (format trunnion-volumetric/1)
    #[arg(long)]
    json: bool,
}

/// A point in tool axes, mm.
#[derive(Clone, Copy)]
struct Point([f64; 3]);

fn point(text: &str) -> Result<Point, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|x: &f64| x.abs() <= 10_000.0)).collect();
    let point = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(Point);
    point.ok_or_else(|| "allowed: three numbers within ±10000 mm, e.g. 0,0,-100".into())
}

fn datum(text: &str) -> Result<Datum, String> {
    one_of(&[("fit", Datum::BestFit), ("model", Datum::Model)], text)
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let outputs = [("--html", args.html.as_deref()), ("--csv", args.csv.as_deref())];
    output::not_an_input(&outputs, args.runs.paths(&args.model))?;
    let loaded = load::runs(&args.runs)?;
    let (outcome, experiment) = (loaded.stated_judgement(), loaded.experiment);
    let fit = experiment.fit(&args.model.stated_model(&experiment)?)?;
    let answer = fit.volumetric(&args.volume, args.steps.map(usize::from), args.tool_point.0, args.datum)?;
    if let Some(path) = &args.html {
        output::write(path, &answer.page())?;
    }
    if let Some(path) = &args.csv {
        output::write(path, &answer.error_map_csv())?;
    }
    if args.json {
        terminal::print_json(&answer.results())?;
    } else {
        terminal::print(&answer.summary())?;
    }
    Ok(outcome)
}
