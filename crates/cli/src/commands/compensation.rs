//! `trunnion compensation`: what a model says of each axis as tables for the controller.

use crate::load::{Loaded, ModelArgs, TrustedArgs};
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::{Context, bail};
use std::path::PathBuf;
use trunnion::report::{axis_errors_text, compensation};
use trunnion::results::{CompensationSummary, CompensationValues};

/// Write the axis errors of a model as compensation tables
///
/// Location errors and the errors of each axis over its own position. Effects that depend on anything else (direction, time,
/// temperature, another axis) are not in the tables; the file names them. Without --corrections the values are errors
/// (actual - nominal): the control must apply the opposite.
///
/// Example: trunnion compensation run.mcap --model machine.model.toml --format isg -o machine.csv
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: TrustedArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Format of the file
    #[arg(long, value_parser = format_names())]
    format: String,
    /// Write corrections (-error) instead of errors
    #[arg(long)]
    corrections: bool,
    /// File to write; without it, standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Print what the file holds and what it leaves out as JSON (format trunnion-compensation-summary/1)
    #[arg(long, requires = "output")]
    json: bool,
}

fn format_names() -> Vec<&'static str> {
    compensation::FORMATS.iter().map(|format| format.name).collect()
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let format = compensation::format(&args.format).context("the command line allows known formats only")?;
    let Loaded { experiment, outcome } = load::trusted_runs(&args.runs)?;
    let errors = experiment.fit(&args.model.model(&experiment)?)?.axis_errors()?;
    if errors.axes.is_empty() {
        let why: Vec<String> = errors.left_out.iter().map(|l| format!("{}: {}", l.effect, l.why)).collect();
        bail!("nothing of the model can be put into tables of axis errors ({})", why.join("; "));
    }
    let values = if args.corrections { CompensationValues::Correction } else { CompensationValues::Error };
    let text = (format.write)(&errors, values);
    let Some(path) = &args.output else {
        terminal::print_verbatim(&text)?;
        return Ok(outcome);
    };
    output::write(path, &text)?;
    if args.json {
        terminal::print_json(&CompensationSummary::new(&errors, values, path.display().to_string()))?;
    } else {
        terminal::print(&axis_errors_text(&errors, &path.display().to_string()))?;
    }
    Ok(outcome)
}
