//! `trunnion compare`: where does the model fail, and what would one more effect do.

use super::add::FormulaArgs;
use crate::load::{ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::bail;
use std::path::PathBuf;
use trunnion::results::{Comparison, Trial, Verdict};
use trunnion::{Fit, FormulaText};

/// Show where the model fails: tables, and a page with plots
///
/// Example: trunnion compare run.mcap --model machine.model.toml --html report.html
///
/// What one more effect would do: trunnion compare run.mcap --try gravity-sag:B --html trial.html
///
/// Against the values that the model file keeps: trunnion compare wednesday.mcap --frozen --model machine.model.toml
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Put this effect in for a trial and show the residual before and after; the model file stays as it is
    #[arg(long = "try", value_name = "EFFECT")]
    trial: Option<String>,
    /// Hold the machine at the values that the model file keeps; only how the ball was set is fitted
    #[arg(long, requires = "model", conflicts_with = "trial")]
    frozen: bool,
    #[command(flatten)]
    formula: FormulaArgs,
    /// Write a self-contained page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    output::not_an_input(&[("--html", args.html.as_deref())], args.runs.paths(&args.model))?;
    let loaded = load::runs(&args.runs)?;
    let (outcome, experiment) = (loaded.judgement(), loaded.experiment);
    let model = args.model.model(&experiment)?;
    if args.frozen {
        frozen(args, model.compare_frozen(&experiment)?)?;
        return Ok(outcome);
    }
    let fit = experiment.fit(&model)?;
    let formula = args.formula.text();
    match &args.trial {
        Some(effect) => {
            try_effect(args, &fit, effect, &formula)?;
            Ok(outcome)
        }
        None if formula != FormulaText::default() => {
            bail!(
                "--site, --component, --expression and --grid describe a formula to try: add --try formula:NAME"
            )
        }
        None => Ok(outcome.with_verdict(compare(args, &fit)?)),
    }
}

fn frozen(args: &Args, answer: Comparison) -> anyhow::Result<()> {
    if let Some(path) = &args.html {
        output::write(path, &trunnion::report::compare_html(&answer, &trunnion::page::label()))?;
    }
    if args.json {
        return terminal::print_json(&Comparison { html: html(args), ..answer });
    }
    terminal::print(&trunnion::report::compare_text(&answer))?;
    output::report_page(args.html.as_deref())
}

fn compare(args: &Args, fit: &Fit) -> anyhow::Result<Verdict> {
    let compared = fit.compare();
    // A page shows the best candidate at work.
    let compared = if args.html.is_some() { compared.with_best() } else { compared };
    if let Some(path) = &args.html {
        output::write(path, &compared.page())?;
    }
    let verdict = compared.diagnosed().results().verdict;
    if args.json {
        terminal::print_json(&Comparison { html: html(args), ..compared.results() })?;
        return Ok(verdict);
    }
    terminal::print(&compared.summary())?;
    output::report_page(args.html.as_deref())?;
    Ok(verdict)
}

fn try_effect(args: &Args, fit: &Fit, effect: &str, formula: &FormulaText) -> anyhow::Result<()> {
    if fit.model().effects().contains(&effect) {
        bail!("{effect} is in the model already; `trunnion ladder` shows what it did");
    }
    let trial = fit.try_effect(effect, formula)?;
    if let Some(path) = &args.html {
        output::write(path, &trial.page())?;
    }
    if args.json {
        return terminal::print_json(&Trial { html: html(args), ..trial.results() });
    }
    terminal::print(&trial.summary())?;
    output::report_page(args.html.as_deref())
}

fn html(args: &Args) -> Option<String> {
    args.html.as_ref().map(|path| path.display().to_string())
}
