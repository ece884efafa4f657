//! `trunnion add`: put an effect into the model, refit, append the ladder row.

use crate::load::{Loaded, TrustedArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::PathBuf;
use trunnion::{FormulaText, Model};

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
    runs: TrustedArgs,
    /// Model file; made from the base model when it does not exist yet
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    formula: FormulaArgs,
    /// Who adds it; kept in the ladder
    #[arg(long, value_name = "NAME")]
    by: Option<String>,
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
    pub fn text(&self) -> FormulaText {
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
    if args.effect.ends_with(".mcap") {
        bail!(
            "{} is no effect; the effect comes first: trunnion add EFFECT RUN.mcap --model FILE",
            args.effect
        );
    }
    let Loaded { experiment, outcome } = load::trusted_runs(&args.runs)?;
    let model = Model::load_or_base(&args.model, &experiment.machine().name)?;
    let mut step = experiment.fit(&model)?.add_as(&args.effect, &args.formula.text())?.dated(&today()?)?;
    if let Some(name) = &args.by {
        step = step.by(name)?;
    }
    step.model().save(&args.model)?;
    if args.json {
        terminal::print_json(&step.results(&args.model.display().to_string()))?;
    } else {
        terminal::print(&step.summary())?;
    }
    Ok(outcome)
}

/// Today's date, UTC, as `YYYY-MM-DD`.
pub fn today() -> anyhow::Result<String> {
    let since_1970 = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .context("the clock is before 1970")?;
    trunnion::moment::day(since_1970.as_nanos().try_into()?).context("the clock is at 1970")
}
