//! `trunnion plan`: what to measure next, or what a cycle would not show.

use crate::load::Loaded;
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::bail;
use std::path::{Path, PathBuf};
use trunnion::report::{plan_text, preview_text};
use trunnion::results::Plan;

/// Plan the cycle that separates confounded effects, or report what a cycle cannot show
///
/// With recordings: takes the effects that `diagnose` leaves confounded (or --rivals). It ranks candidate cycles by expected evidence
/// per minute of machine time and writes the best. With --cycle: reports, before anything is measured, which effects that
/// cycle cannot show and which are confounded in it.
///
/// Example: trunnion plan run.mcap --model machine.model.toml -o next.toml
#[derive(clap::Args)]
pub struct Args {
    /// Recordings (.mcap); several are fitted together
    #[arg(value_name = "RUN", required_unless_present = "cycle")]
    runs: Vec<PathBuf>,
    /// Model file; without it the base model (location errors and ball setting)
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Effects to separate, e.g. backlash:C,servo-lag:C; the first counts most; without it those the diagnosis leaves open
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    rivals: Vec<String>,
    /// A cycle to look at before it is measured (format trunnion-cycle/1)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["runs", "model", "rivals", "output", "anyway"])]
    cycle: Option<PathBuf>,
    /// Go on although the runs are not plausible or not whole
    #[arg(long)]
    anyway: bool,
    /// Cycle file to write
    #[arg(short, long, value_name = "NEXT.TOML")]
    output: Option<PathBuf>,
    /// Print JSON (format trunnion-plan/1 or trunnion-preview/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    match &args.cycle {
        Some(path) => look_at(path, args.json),
        None => plan_next(args),
    }
}

fn look_at(path: &Path, json: bool) -> anyhow::Result<Outcome> {
    let preview = trunnion::cycles::preview(path)?;
    if json {
        terminal::print_json(&preview)?;
    } else {
        terminal::print(&preview_text(&preview))?;
    }
    Ok(Outcome::Done)
}

fn plan_next(args: &Args) -> anyhow::Result<Outcome> {
    let inputs = args.runs.iter().chain(&args.model).map(PathBuf::as_path);
    output::not_an_input(&[("-o", args.output.as_deref())], inputs)?;
    let Loaded { experiment, outcome } = load::trusted_runs(&load::TrustedArgs {
        runs: load::RunArgs::of(args.runs.clone()),
        anyway: args.anyway,
    })?;
    let model = load::ModelArgs { model: args.model.clone() }.stated_model(&experiment)?;
    let Some(plan) = experiment.fit(&model)?.plan(&args.rivals)? else {
        bail!(
            "nothing is confused and nothing is hidden in these runs; name effects with --rivals to compare them"
        )
    };
    let written = match (&args.output, &plan.next) {
        (Some(path), Some(cycle)) => {
            output::write(path, &cycle_text(&plan, &cycle.cycle))?;
            Some(path)
        }
        _ => None,
    };
    if args.json {
        let written = written.map(|path| path.display().to_string());
        terminal::print_json(&Plan { written, ..plan })?;
    } else {
        terminal::print(&plan_text(&plan))?;
        match (written, &args.output) {
            (Some(path), _) => terminal::print(&format!("\ncycle file: {}\n", path.display()))?,
            (None, Some(path)) => terminal::print(&format!(
                "\n{} was not written: there is no cycle that would help.\n",
                path.display()
            ))?,
            (None, None) => {}
        }
    }
    Ok(outcome)
}

/// The cycle file with the reason on top.
fn cycle_text(plan: &Plan, cycle: &str) -> String {
    let reason: String = plan.answer.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("# {reason}\n{cycle}")
}
