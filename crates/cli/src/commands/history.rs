//! `trunnion history`: the runs of one machine.

use super::progress_bar::ProgressBar;
use crate::load::ModelArgs;
use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::Model;
use trunnion::gaps::Missing;
use trunnion::history::{
    Keeper, Wanted, Working, corrections, enter_correction, entered, history, newest_machine,
};
use trunnion::results::HistoryRun;
use trunnion_core::{Clock, chain};
use trunnion_service::clock::SystemClock;
use trunnion_service::run_record::{self, Known};

/// Runs of one machine in order of time: what changed since the last run, and which effect
///
/// Every run is fitted with the same model. Control limits come from the machine's own earlier runs. An unchanged machine gives
/// at most one false alarm in a year of daily runs, over all values together (docs/use/history.md). What was worked out of a run is kept
/// next to it (`NAME.history.jsonl`) for the next time.
///
/// Example: trunnion history --folder /var/lib/trunnion --model machine.model.toml
///
/// When a correction was entered: trunnion history --folder runs --corrected "axes B and C" --by Ada
///
/// From a run on: trunnion history table-bc --folder runs --since after-correction
#[derive(clap::Args)]
pub struct Args {
    /// Name of the machine; without it, that of the newest recording
    #[arg(value_name = "MACHINE", value_parser = machine)]
    machine: Option<String>,
    /// Folder of recordings (.mcap)
    #[arg(long, value_name = "DIR", default_value = ".")]
    folder: PathBuf,
    #[command(flatten)]
    model: ModelArgs,
    /// First run after a correction or repair: control limits begin with it
    #[arg(long, value_name = "RUN")]
    since: Option<String>,
    /// Keep in the folder that this correction was entered into the control now: limits begin again, and the runs before and after it are
    /// compared
    #[arg(long, value_name = "WHAT", requires = "by")]
    corrected: Option<String>,
    /// Who entered it
    #[arg(long, value_name = "NAME", requires = "corrected")]
    by: Option<String>,
    /// Print JSON (format trunnion-history/1)
    #[arg(long)]
    json: bool,
}

/// A file is no name of a machine, not even one that a machine could have.
fn machine(text: &str) -> Result<String, String> {
    // A folder may well be called after its machine.
    if text.ends_with(".mcap") || Path::new(text).is_file() {
        return Err("a history is of a machine, not of a file: give its name, or --folder with the folder of its recordings".into());
    }
    Ok(text.into())
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let runs = recordings(&args.folder)?;
    if runs.is_empty() {
        bail!("there is no recording (.mcap) in {}", args.folder.display());
    }
    if let Some((what, by)) = args.corrected.as_deref().zip(args.by.as_deref()) {
        let machine = args.machine.clone().or_else(|| newest_machine(&runs));
        let machine = machine.context("no recording says which machine was corrected: name it")?;
        let correction = entered(machine, SystemClock::start().wall_ns(), by, what)?;
        let kept = enter_correction(&args.folder, &correction)?;
        terminal::remark(&format!("{} keeps the correction of {}", kept.display(), correction.at));
    }
    let wanted = Wanted {
        machine: args.machine.clone(),
        model: args.model.model.as_ref().map(Model::load).transpose()?,
        since: args.since.clone(),
        corrections: corrections(&args.folder)?,
    };
    let mut bar = ProgressBar::new(false);
    let shows = |working: Working<'_>| bar.show_of(working.what, working.done, working.total);
    let mut keeper = Keeper::new(shows);
    let answer = history(&runs, &wanted, &mut keeper);
    let not_kept = keeper.not_kept().map(|failure| chain(failure));
    drop(keeper);
    bar.clear();
    let answer = answer?;
    if let Some(failure) = not_kept {
        terminal::remark(&format!("what was worked out is not kept for the next time: {failure}"));
    }
    if args.json {
        terminal::print_json(&answer)?;
    } else {
        terminal::print(&trunnion::report::history_text(&answer))?;
    }
    let of_run = |run: &HistoryRun| {
        let named = |loss: &String| format!("{}: {loss}", run.run);
        run.losses.iter().map(named).collect::<Vec<_>>()
    };
    let gaps = answer.runs.iter().flat_map(of_run).collect();
    let outcome = load::outcome(&Missing { gaps, damage: None });
    let outcome = if answer.why_no_change.is_empty() { outcome } else { outcome.or_withheld() };
    let troubled = answer.runs.iter().any(|run| !run.trouble.is_empty());
    Ok(if troubled { Outcome::DataLoss } else { outcome })
}

/// The recordings of each run: a further part is no run of its own.
fn recordings(folder: &Path) -> anyhow::Result<Vec<Vec<PathBuf>>> {
    std::fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let runs = Known::read(folder).runs;
    Ok(runs.iter().map(|(recording, record)| run_record::files(recording, record)).collect())
}
