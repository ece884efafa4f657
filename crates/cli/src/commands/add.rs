//! `trunnion add`: put an effect into the model, refit, append the ladder row.

use crate::load::RunArgs;
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::PathBuf;
use trunnion::analysis;
use trunnion::analysis::FormulaText;
use trunnion_effects::{LadderRow, Model, ModelEffect};
use trunnion_engine::Experiment;

/// Add an effect to the model, refit, and show how far the error falls
///
/// Example: trunnion add gravity-sag:B run.mcap --model machine.model.toml
///
/// An expression of your own: trunnion add formula:hose run.mcap --model machine.model.toml --site axis:B
/// --component ea --expression "pull*step(B - start)" --grid start=0.2,0.4,0.6
///
/// An effect that was written into the model file by hand gets its ladder row in the same way.
#[derive(clap::Args)]
pub struct Args {
    /// Effect id, e.g. gravity-sag:B, or formula:NAME
    effect: String,
    #[command(flatten)]
    runs: RunArgs,
    /// Model file; made from the base model when it does not exist yet
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    formula: FormulaArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The expression of a formula:NAME; what is not given is taken from what `diagnose` proposes under that name.
#[derive(clap::Args)]
pub struct FormulaArgs {
    /// Where the formula acts: axis:B, ball, spindle, reading
    #[arg(long, value_name = "SITE")]
    site: Option<String>,
    /// Component of the formula: dx, dy, dz (um), ea, eb, ec (urad)
    #[arg(long, value_name = "COMPONENT")]
    component: Option<String>,
    /// Expression over A B C (rad), X Y Z (mm), t (s), vB, dirB, T_NAME; every other name is a parameter
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    expression: Option<String>,
    /// Values to try of a parameter that enters non-linearly, NAME=1,2,3; may be given again
    #[arg(long, value_name = "NAME=VALUES", value_parser = grid)]
    grid: Vec<(String, Vec<f64>)>,
}

impl FormulaArgs {
    /// As the analysis takes it.
    pub fn told(&self) -> FormulaText {
        FormulaText {
            site: self.site.clone(),
            component: self.component.clone(),
            expression: self.expression.clone(),
            grid: self.grid.clone(),
        }
    }
}

fn grid(text: &str) -> Result<(String, Vec<f64>), String> {
    let advice = "NAME=NUMBER,NUMBER,… such as start=0.2,0.4";
    let (name, values) = text.split_once('=').ok_or_else(|| format!("has no \"=\"; allowed: {advice}"))?;
    let number = |cell: &str| {
        cell.trim().parse::<f64>().map_err(|_| format!("\"{cell}\" is no number; allowed: {advice}"))
    };
    Ok((name.trim().into(), values.split(',').map(number).collect::<Result<_, _>>()?))
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let load::Loaded { runs, outcome, .. } = load::runs(&args.runs)?;
    let experiment = Experiment::new(&runs)?;
    let text = if args.model.exists() {
        load::read(&args.model)?
    } else {
        Model::base(&experiment.machine().name).to_text()
    };
    let model = Model::parse(&args.model.display().to_string(), &text)?;
    let told = args.formula.told();
    let (step, longer) = match model.effects.iter().position(|entry| entry.id == args.effect) {
        None => {
            let entries = analysis::entries(&experiment, &model, &args.effect, &told)?;
            let step = analysis::put(&experiment, &model, entries, &today()?)?;
            let longer =
                step.entries.iter().try_fold(text.clone(), |text, entry| Model::append(&text, entry))?;
            (step, longer)
        }
        Some(at) => {
            let entry = written_by_hand(args, &model, at, &told)?;
            let mut shorter = model.clone();
            shorter.effects.truncate(at);
            let step = analysis::put(&experiment, &shorter, vec![entry], &today()?)?;
            let longer = Model::with_ladder_row(&text, &args.effect, ladder_row(&step)?)?;
            (step, longer)
        }
    };
    std::fs::write(&args.model, longer).with_context(|| format!("cannot write {}", args.model.display()))?;
    let row = ladder_row(&step)?;
    if args.json {
        terminal::print_json(&serde_json::json!({
            "effect": args.effect, "model": args.model.display().to_string(),
            "error_before_um": row.error_before_um, "error_after_um": row.error_after_um,
            "holdout_before_um": row.holdout_before_um, "holdout_after_um": row.holdout_after_um,
            "holdout_unit": row.holdout_unit, "noise_um": row.noise_um, "moved": super::ladder::moved_json(row),
            "identification": step.identification.to_json(),
        }))?;
    } else {
        let ladder = trunnion::page::ladder(&step.model);
        terminal::print(&trunnion_report::ladder_text(&ladder, row.noise_um))?;
        terminal::print("\n")?;
        terminal::print(&trunnion_report::identification_text(&(&step.identification).into()))?;
    }
    Ok(outcome)
}

fn ladder_row(step: &analysis::Step) -> anyhow::Result<&LadderRow> {
    step.entry.ladder.as_ref().context("an added effect has a ladder row")
}

/// The entry at `at`, when it waits for its ladder row.
fn written_by_hand(args: &Args, model: &Model, at: usize, told: &FormulaText) -> anyhow::Result<ModelEffect> {
    let file = args.model.display();
    let entry = &model.effects[at];
    if *told != FormulaText::default() {
        bail!(
            "{} is in {file} already; edit its expression there, or `trunnion remove` it first",
            args.effect
        );
    }
    if entry.ladder.is_some() || trunnion_effects::catalogue::BASE.contains(&entry.id.as_str()) {
        bail!(
            "{} is in {file} already; `trunnion remove` it, or delete its [effect.ladder] to measure it anew",
            args.effect
        );
    }
    Ok(entry.clone())
}

/// Today's date, UTC, as `YYYY-MM-DD`.
pub fn today() -> anyhow::Result<String> {
    let since_1970 = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .context("the clock is before 1970")?;
    let stamp = trunnion_protocol::mtconnect::format_timestamp(i64::try_from(since_1970.as_nanos())?);
    Ok(stamp.chars().take(10).collect())
}
