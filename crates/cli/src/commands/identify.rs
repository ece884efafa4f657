//! `trunnion identify`: the machine's errors with uncertainties, and what is not observable; or by a named method of the
//! literature.

use super::add::today;
use crate::load::{ModelArgs, RunArgs};
use crate::one_of::one_of;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use std::path::PathBuf;
use trunnion::report::{identification_text, location_text, timing_text};
use trunnion::results::sentences::sources;
use trunnion::second_opinion::add_bar_result;
use trunnion::{Convention, EVERY_METHOD, MethodOptions, Notation, method};

/// Identify the machine's errors from recordings
///
/// Without --method all effects of the model are fitted together. With --method a closed recipe of the literature is
/// applied (docs/use/methods.md).
///
/// Example: trunnion identify run.mcap --model machine.model.toml
///
/// Values for later runs: trunnion identify monday.mcap tuesday.mcap --model machine.model.toml --keep
///
/// Example: trunnion identify c.mcap --method two-height --html two-height.html
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Keep the fitted values in the model file, so that it predicts other runs
    #[arg(long, requires = "model")]
    keep: bool,
    /// Named method instead of the joint fit
    #[arg(long, value_name = "NAME", conflicts_with = "model", long_help = method_help(), value_parser = method_name)]
    method: Option<String>,
    /// Location errors in a notation as well: absolute (lines in the machine, ISO 230-1) or relative (against the carrying axis)
    #[arg(long, value_name = "NAME", conflicts_with = "method", value_parser = notation)]
    notation: Option<Notation>,
    /// Rotary axis that the method judges, by its name in the machine file; by default the one that turns alone
    #[arg(long, value_name = "NAME", requires = "method")]
    axis: Option<String>,
    /// Signs of the method's values: right-handed, or source (as its source prints them)
    #[arg(long, value_name = "NAME", requires = "method", default_value = "right-handed", value_parser = convention)]
    convention: Convention,
    /// Magnification of deviations on maps of places (error-map), e.g. 10000; by default what suits them
    #[arg(long, value_name = "TIMES", requires = "method", value_parser = magnification)]
    magnification: Option<f64>,
    /// Result file of a Renishaw QC20-W (.b5r) of the same circles: its numbers next to ours
    #[arg(long, value_name = "FILE.B5R", requires = "method")]
    against: Option<PathBuf>,
    /// Page with the method's charts
    #[arg(long, value_name = "FILE", requires = "method")]
    html: Option<PathBuf>,
    /// Print JSON (format trunnion-identification/1, or trunnion-findings/1 with --method)
    #[arg(long)]
    json: bool,
}

fn method_name(text: &str) -> Result<String, String> {
    method(text).map(|method| method.name.into()).map_err(|unknown| unknown.to_string())
}

fn method_help() -> String {
    let lines = EVERY_METHOD
        .iter()
        .map(|method| format!("  {}: {} [{}]", method.name, method.title, sources(method.source)));
    format!("Named method instead of the joint fit:\n{}", lines.collect::<Vec<_>>().join("\n"))
}

fn convention(text: &str) -> Result<Convention, String> {
    one_of(&Convention::NAMES, text)
}

fn magnification(text: &str) -> Result<f64, String> {
    let times = text.parse::<f64>().ok().filter(|times| times.is_finite() && *times >= 1.0);
    times.ok_or_else(|| "is no number of 1 or more".into())
}

fn notation(text: &str) -> Result<Notation, String> {
    one_of(&Notation::NAMES, text)
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match &args.method {
        Some(name) => by_method(args, name),
        None => jointly(args),
    }
}

fn jointly(args: &Args) -> anyhow::Result<Outcome> {
    let loaded = load::runs(&args.runs)?;
    let (outcome, experiment) = (loaded.judgement(), loaded.experiment);
    let fit = experiment.fit(&args.model.model(&experiment)?)?;
    if let Some(path) = args.model.model.as_ref().filter(|_| args.keep) {
        fit.keeping(&today()?)?.save(path)?;
    }
    let mut answer = fit.identified();
    answer.location_errors = args.notation.map(|notation| fit.location_errors(notation));
    if args.json {
        terminal::print_json(&answer)?;
    } else {
        let located = answer.location_errors.as_ref().map_or(String::new(), location_text);
        terminal::print(&(identification_text(&answer) + &located + &timing_text(&answer.time_quality)))?;
    }
    Ok(outcome)
}

fn by_method(args: &Args, name: &str) -> anyhow::Result<Outcome> {
    let inputs = args.runs.paths(&args.model).chain(args.against.as_deref());
    output::not_an_input(&[("--html", args.html.as_deref())], inputs)?;
    let loaded = load::runs_for_method(&args.runs)?;
    let (outcome, experiment) = (loaded.judgement(), loaded.experiment);
    let axis = args.axis.as_deref().map(|name| experiment.rotary_joint(name)).transpose()?;
    let options = MethodOptions { axis, convention: args.convention, magnification: args.magnification };
    let mut findings = experiment.by_method(name, &options)?;
    if let Some(path) = &args.against {
        add_bar_result(&mut findings, path)?;
    }
    output::findings(&findings, args.html.as_deref(), args.json)?;
    Ok(outcome)
}
