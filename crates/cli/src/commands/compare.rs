//! `trunnion compare`: where does the model fail, and what would one more effect do.

use super::add::{FormulaArgs, today};
use crate::load::{ModelArgs, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::analysis::{FormulaText, Step};
use trunnion::{analysis, page};
use trunnion_effects::{Formula, Model};
use trunnion_engine::compare::Place;
use trunnion_engine::{Diagnosis, Experiment, Verdict};
use trunnion_report::{
    CompareInput, Trial, compare_html, compare_text, time_quality_json, trial_html, trial_text,
};
use trunnion_sync::time_quality::TimeQuality;

/// Show where the model fails: tables, and a page with plots
///
/// Example: trunnion compare run.mcap --model machine.model.toml --html report.html
///
/// What one more effect would do: trunnion compare run.mcap --try gravity-sag:B --html trial.html
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    #[command(flatten)]
    model: ModelArgs,
    /// Put this effect in for a trial and show the residual before and after; the model file stays as it is
    #[arg(long = "try", value_name = "EFFECT")]
    trial: Option<String>,
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
    let load::Loaded { runs, outcome, mut timing } = load::runs(&args.runs)?;
    let (experiment, model) = load::experiment(&runs, &args.model)?;
    load::tell_delay(&experiment, &mut timing)?;
    let told = args.formula.told();
    match &args.trial {
        Some(effect) => try_effect(args, &experiment, &model, effect, &told)?,
        None if told != FormulaText::default() => {
            bail!(
                "--site, --component, --expression and --grid describe a formula to try: add --try formula:NAME"
            )
        }
        None => compare(args, &experiment, &model, &timing)?,
    }
    Ok(outcome)
}

fn compare(
    args: &Args,
    experiment: &Experiment,
    model: &Model,
    timing: &[TimeQuality],
) -> anyhow::Result<()> {
    let fit = trunnion_engine::identify(experiment, model, &trunnion_engine::fit::Options::default())?;
    let diagnosis = analysis::diagnose_and_plan(experiment, model)?;
    let mut input = page::compare_input(experiment, &fit, Some(&diagnosis), model, &[], timing);
    if let Some(path) = &args.html {
        if let Some(effect) = best(&diagnosis) {
            // The page shows the best candidate at work.
            let entries = match &diagnosis.formula {
                Some(formula) if Formula::name_of(&effect).is_some() => formula.entries.clone(),
                _ => analysis::entries(experiment, model, &effect, &FormulaText::default())?,
            };
            let step = analysis::put(experiment, model, entries, &today()?)?;
            input.trial = Some(trial_of(experiment, &step)?);
        }
        write(path, &compare_html(&input))?;
    }
    if args.json {
        terminal::print_json(&serde_json::json!({
            "format": "trunnion-comparison/1",
            "time_quality": timing.iter().map(time_quality_json).collect::<Vec<_>>(),
            "places": places_json(&input.places),
            "identification": fit.to_json(),
            "diagnosis": diagnosis.to_json(),
            "html": args.html.as_ref().map(|path| path.display().to_string()),
        }))?;
    } else {
        terminal::print(&compare_text(&input))?;
        told_page(args)?;
    }
    Ok(())
}

fn try_effect(
    args: &Args,
    experiment: &Experiment,
    model: &Model,
    effect: &str,
    told: &FormulaText,
) -> anyhow::Result<()> {
    if model.effects.iter().any(|entry| entry.id == effect) {
        bail!("{effect} is in the model already; `trunnion ladder` shows what it did");
    }
    let entries = analysis::entries(experiment, model, effect, told)?;
    let step = analysis::put(experiment, model, entries, &today()?)?;
    let trial = trial_of(experiment, &step)?;
    if let Some(path) = &args.html {
        let input =
            CompareInput { label: page::label(), ..CompareInput::new(experiment, &step.before, None) };
        write(path, &trial_html(&input, &trial))?;
    }
    if args.json {
        terminal::print_json(&serde_json::json!({
            "format": "trunnion-trial/1",
            "effect": effect,
            "rms_um": { "before": trial.fit_um[0], "after": trial.fit_um[1] },
            "holdout_rms_um": { "before": trial.holdout_um[0], "after": trial.holdout_um[1] },
            "noise_um": trial.noise.rms_um,
            "then": trial.then.as_ref().map(|then| serde_json::json!({
                "verdict": then.verdict.as_str(), "candidate": then.candidates.first().map(|c| c.effect.as_str()),
            })),
            "places": { "before": places_json(&trial.places[0]), "after": places_json(&trial.places[1]) },
            "moved": step.entry.ladder.as_ref().map(super::ladder::moved_json),
            "identification": step.identification.to_json(),
            "html": args.html.as_ref().map(|path| path.display().to_string()),
        }))?;
    } else {
        terminal::print(&trial_text(&trial))?;
        told_page(args)?;
    }
    Ok(())
}

/// The effect or formula that leads, if the diagnosis names one.
fn best(diagnosis: &Diagnosis) -> Option<String> {
    match diagnosis.verdict {
        Verdict::NoiseFloor => None,
        Verdict::MissingEffect => diagnosis.candidates.first().map(|candidate| candidate.effect.clone()),
        Verdict::UnnamedStructure => diagnosis.formula.as_ref().map(|formula| Formula::id_of(&formula.name)),
    }
}

fn trial_of(experiment: &Experiment, step: &Step) -> anyhow::Result<Trial> {
    let then = analysis::diagnose(experiment, &step.model)?;
    Ok(Trial::new(experiment, &step.entry, &step.entries, &step.before, &step.identification, Some(then)))
}

fn places_json(places: &[Place]) -> Vec<serde_json::Value> {
    let place = |place: &Place| {
        serde_json::json!({
            "words": place.to_string(), "component": place.component, "ranges": place.ranges,
            "direction": place.direction, "setup": place.setup, "time": place.time, "mean_um": place.mean_um,
            "turns_with": place.turns_with,
            "readings": place.readings, "share": place.share,
        })
    };
    places.iter().map(place).collect()
}

fn write(path: &Path, page: &str) -> anyhow::Result<()> {
    std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display()))
}

fn told_page(args: &Args) -> anyhow::Result<()> {
    if let Some(path) = &args.html {
        terminal::print(&format!("page: {}\n", path.display()))?;
    }
    Ok(())
}
