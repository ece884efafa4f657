//! `trunnion identify`: the machine's errors with uncertainties, and what cannot be seen; or by a named method of the
//! literature.

use crate::load::{ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;
use trunnion_core::AxisLetter;
use trunnion_methods::notation::{Layout, LocationError, Notation};
use trunnion_methods::recipes;
use trunnion_methods::recipes::{Convention, MethodOptions, REGISTRY};
use trunnion_report::{
    findings_html, findings_text, identification_text, location_text, time_quality_json, timing_text,
};

/// Identify the machine's errors from recordings
///
/// Without --method all effects of the model are fitted together. With --method a closed recipe of the literature is
/// applied (docs/use/methods.md).
///
/// Example: trunnion identify run.mcap --model machine.model.toml
///
/// Example: trunnion identify c.mcap --method two-height --html two-height.html
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Named method instead of the joint fit
    #[arg(long, value_name = "NAME", conflicts_with = "model", long_help = method_help())]
    method: Option<String>,
    /// Location errors in a notation as well: absolute (lines in the machine, ISO 230-1) or relative (against the carrying axis)
    #[arg(long, value_name = "NAME", conflicts_with = "method", value_parser = notation)]
    notation: Option<Notation>,
    /// Axis that the method judges; by default the one that turns alone
    #[arg(long, value_name = "LETTER", requires = "method", value_parser = axis)]
    axis: Option<AxisLetter>,
    /// Signs of the method's values: right-handed, or source (as its source prints them)
    #[arg(long, value_name = "NAME", requires = "method", default_value = "right-handed", value_parser = convention)]
    convention: Convention,
    /// Page with the method's charts
    #[arg(long, value_name = "FILE", requires = "method")]
    html: Option<PathBuf>,
    /// Print JSON (format trunnion-identification/1, or trunnion-findings/1 with --method)
    #[arg(long)]
    json: bool,
}

fn method_help() -> String {
    let lines =
        REGISTRY.iter().map(|method| format!("  {}: {} [{}]", method.name, method.title, method.source));
    format!("Named method instead of the joint fit:\n{}", lines.collect::<Vec<_>>().join("\n"))
}

fn axis(text: &str) -> Result<AxisLetter, String> {
    let letter = AxisLetter::parse(text).filter(|letter| letter.is_rotary());
    letter.ok_or_else(|| "allowed: A, B, C".into())
}

fn convention(text: &str) -> Result<Convention, String> {
    let named = Convention::NAMES.into_iter().find(|(name, _)| *name == text);
    named
        .map(|(_, convention)| convention)
        .ok_or_else(|| format!("allowed: {}", Convention::NAMES.map(|(name, _)| name).join(", ")))
}

fn notation(text: &str) -> Result<Notation, String> {
    let named = Notation::NAMES.into_iter().find(|(name, _)| *name == text);
    named
        .map(|(_, notation)| notation)
        .ok_or_else(|| format!("allowed: {}", Notation::NAMES.map(|(name, _)| name).join(", ")))
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match &args.method {
        Some(name) => by_method(args, name),
        None => jointly(args),
    }
}

fn jointly(args: &Args) -> anyhow::Result<Outcome> {
    let load::Loaded { runs, outcome, mut timing } = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    load::tell_delay(&experiment, &mut timing)?;
    let identification =
        trunnion_engine::identify(&experiment, &model, &trunnion_engine::fit::Options::default())?;
    let located = args
        .notation
        .map(|notation| (notation, Layout::new(experiment.machine()).of_fit(&identification, notation)));
    if args.json {
        let mut json = identification.to_json();
        if let Some((notation, errors)) = &located {
            json["location_errors"] = location_json(*notation, errors);
        }
        if !timing.is_empty() {
            json["time_quality"] = timing.iter().map(time_quality_json).collect();
        }
        terminal::print_json(&json)?;
    } else {
        let mut text = identification_text(&(&identification).into());
        if let Some((notation, errors)) = &located {
            text += &location_text(errors, *notation);
        }
        text += &timing_text(&timing);
        terminal::print(&text)?;
    }
    Ok(outcome)
}

fn location_json(notation: Notation, errors: &[LocationError]) -> serde_json::Value {
    let values = errors.iter().map(|error| {
        let unit = error.unit();
        serde_json::json!({
            "symbol": error.symbol,
            "axis": error.component.axis.as_str(),
            "against": match notation { Notation::Relative => error.component.against.as_str(), Notation::Absolute => "machine" },
            "value": error.value.map(|x| x * unit.per_inside),
            "u": error.u.map(|x| x * unit.per_inside),
            "unit": unit.symbol,
            "without_number": error.without_number,
        })
    });
    serde_json::json!({"notation": notation.name(), "values": values.collect::<Vec<_>>()})
}

fn by_method(args: &Args, name: &str) -> anyhow::Result<Outcome> {
    let method = recipes::find(name)?;
    let load::Loaded { runs, outcome, .. } = load::runs_for_method(&args.runs)?;
    let findings = (method.run)(&runs, &MethodOptions { axis: args.axis, convention: args.convention })?;
    if let Some(path) = &args.html {
        std::fs::write(path, findings_html(&findings, &trunnion::page::label()))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        terminal::print_json(&findings.to_json())?;
    } else {
        terminal::print(&findings_text(&findings))?;
    }
    Ok(outcome)
}
