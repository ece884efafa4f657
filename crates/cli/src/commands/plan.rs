//! `trunnion plan`: what to measure next, or what a cycle would not show.

use crate::load::Loaded;
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::results;
use trunnion_cycles::Cycle;
use trunnion_engine::next_cycle;
use trunnion_engine::next_cycle::{Options, Plan, Preview};

/// Plan the cycle that separates what cannot be told apart, or say what a cycle cannot show
///
/// With recordings: takes the effects that `diagnose` confuses (or --rivals), weighs candidate cycles by expected evidence per
/// minute of machine time and writes the best. With --cycle: says, before anything is measured, which effects that cycle
/// cannot show and which coincide in it.
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
    /// Effects to tell apart, e.g. backlash:C,servo-lag:C; the first counts most; without it those the diagnosis leaves open
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    rivals: Vec<String>,
    /// A cycle to look at before it is measured (format trunnion-cycle/1)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["runs", "model", "rivals", "output"])]
    cycle: Option<PathBuf>,
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
    let cycle = Cycle::parse(&path.display().to_string(), &load::read(path)?)?;
    let machine = load::machine(&cycle.machine)?;
    let preview = next_cycle::preview(&machine, &cycle, &Options::default())?;
    if json {
        terminal::print_json(&results::Preview::from(&preview))?;
    } else {
        terminal::print(&preview_text(&preview))?;
    }
    Ok(Outcome::Done)
}

fn plan_next(args: &Args) -> anyhow::Result<Outcome> {
    let Loaded { experiment, outcome } = load::runs(&load::RunArgs::of(args.runs.clone()))?;
    let model = load::ModelArgs { model: args.model.clone() }.model(&experiment)?;
    let Some(plan) = experiment.fit(&model)?.plan(&args.rivals)? else {
        bail!(
            "nothing is confused and nothing is hidden in these runs; name effects with --rivals to compare them"
        )
    };
    let written = match (&args.output, &plan.next) {
        (Some(path), Some(cycle)) => {
            std::fs::write(path, cycle_text(&plan, cycle))
                .with_context(|| format!("cannot write {}", path.display()))?;
            Some(path)
        }
        _ => None,
    };
    if args.json {
        let written = written.map(|path| path.display().to_string());
        terminal::print_json(&results::Plan { written, ..(&plan).into() })?;
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
fn cycle_text(plan: &Plan, cycle: &Cycle) -> String {
    let reason: String = plan.answer.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    format!("# {reason}\n{}", cycle.to_text())
}

fn plan_text(plan: &Plan) -> String {
    let mut text = format!("{}\n", plan.answer);
    if plan.separates {
        text += &format!(
            "\nTo tell apart: {}. In the present data: odds 10^{:.1}.\n",
            plan.effects.join(", "),
            plan.before_ln / std::f64::consts::LN_10
        );
    } else {
        text += &format!("\nNot seen so far: {}.\n", plan.effects.join(", "));
    }
    text += "\nConsidered\n";
    text += &if plan.separates { separating(plan) } else { revealing(plan) };
    if !plan.never_shown.is_empty() {
        text += &format!("\nNo cycle considered shows: {}.\n", plan.never_shown.join(", "));
    }
    text += "\nAssumed\n";
    for line in &plan.assumptions {
        text += &format!("  {line}\n");
    }
    text
}

fn separating(plan: &Plan) -> String {
    let pairs = plan.effects.len() * (plan.effects.len() - 1) / 2;
    let head = ["cycle", "minutes", "pairs apart", "odds after", "hardest pair", "what"].map(String::from);
    let rows = plan.considered.iter().map(|row| {
        [
            row.name.clone(),
            format!("{:.1}", row.minutes),
            format!("{}/{pairs}", row.apart.len()),
            format!("10^{:.1}", row.separation_ln / std::f64::consts::LN_10),
            row.hardest.join(" / "),
            row.what.clone(),
        ]
    });
    table(&std::iter::once(head).chain(rows).collect::<Vec<_>>())
}

fn revealing(plan: &Plan) -> String {
    let head = ["cycle", "minutes", "shows", "tells apart", "what"].map(String::from);
    let rows = plan.considered.iter().map(|row| {
        [
            row.name.clone(),
            format!("{:.1}", row.minutes),
            format!("{}/{}", row.shows.len(), plan.effects.len()),
            format!("{}/{}", row.tells.len(), plan.effects.len()),
            row.what.clone(),
        ]
    });
    table(&std::iter::once(head).chain(rows).collect::<Vec<_>>())
}

fn preview_text(preview: &Preview) -> String {
    let mut text = format!(
        "Cycle {}: {} points, about {:.0} minutes with mounting.\n\nIt shows: {}.\n",
        preview.cycle,
        preview.points,
        preview.minutes,
        preview.visible.join(", ")
    );
    for (title, how, list) in [
        (
            "It cannot show, because location errors and ball settings imitate them",
            "seen by: ",
            &preview.invisible,
        ),
        ("Out of reach in it", "", &preview.out_of_reach),
    ] {
        if !list.is_empty() {
            text += &format!("\n{title}\n");
            let rows: Vec<[String; 2]> =
                list.iter().map(|(effect, seen_by)| [effect.clone(), format!("{how}{seen_by}")]).collect();
            text += &table(&rows);
        }
    }
    if !preview.aliases.is_empty() {
        text += "\nCoincide in it\n";
        let rows: Vec<[String; 4]> = preview
            .aliases
            .iter()
            .map(|alias| {
                let apart = match &alias.separated_by {
                    Some((name, minutes)) => format!("told apart by {name} ({minutes:.0} min)"),
                    None => "no cycle of poses and feeds considered tells them apart".into(),
                };
                [
                    alias.one.clone(),
                    alias.other.clone(),
                    format!("{} of {}", alias.shared, alias.directions[0].min(alias.directions[1])),
                    apart,
                ]
            })
            .collect();
        text += &table(&rows);
    }
    text
}

/// Columns two blanks apart.
fn table<const N: usize>(rows: &[[String; N]]) -> String {
    let width = |j: usize| rows.iter().map(|row| row[j].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..N).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().enumerate().map(|(j, cell)| format!("{cell:<width$}", width = widths[j]));
        text += &format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end());
    }
    text
}
