//! The blind trial: physics is hidden in the simulator, the program gets the recording alone, and its answers are counted.
//!
//! `stage` has the machine and the grids, `cases` says what is hidden, `noise` what disturbs, `trial` asks, `score` judges,
//! `library` asks methods that choose columns, `table` writes `docs/measured/blind-trial.md`.

mod baseline_table;
mod cases;
mod coverage;
mod export;
mod library;
mod noise;
mod score;
mod stage;
mod table;
#[cfg(test)]
mod tests;
mod trial;

use anyhow::{Context, bail};
use cases::{Case, Group};
use clap::Parser;
use stage::Stage;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use trial::Trial;

/// Hide physics in a simulated machine, ask the diagnosis, count right and wrong answers
#[derive(Parser)]
#[command(name = "blind-trial")]
pub struct Args {
    /// Trials of each case; twenty times as many with nothing hidden
    #[arg(long, default_value_t = 1, value_name = "N")]
    seeds: u64,
    /// Number of the first trial of each case
    #[arg(long, default_value_t = 0, value_name = "N")]
    first_seed: u64,
    /// Only cases of which the label holds every word, e.g. `single backlash white 0.5`
    #[arg(long, default_value = "", value_name = "TEXT")]
    only: String,
    /// Stop after so many trials
    #[arg(long, value_name = "N")]
    most: Option<usize>,
    /// Write columns, readings, truth and answer of every trial below this folder, for tests/peers/sparse_methods.py
    #[arg(long, value_name = "FOLDER")]
    export: Option<PathBuf>,
    /// Print a line for every answer that is not right and every interval that misses the truth
    #[arg(long)]
    verbose: bool,
    /// Only count how often intervals of uncertainty hold the truth
    #[arg(long)]
    coverage_only: bool,
    /// Write the tables to this file
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
}

/// Trials at a time.
const WORKERS: usize = 2;
/// Trials between two lines of progress.
const PROGRESS: usize = 25;

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let stage = Stage::new();
    let visible = cases::visible(&stage);
    let seeds = args.first_seed..args.first_seed + args.seeds;
    let mut cases = cases::cases(&visible, seeds, &args.only);
    cases.truncate(args.most.unwrap_or(usize::MAX));
    if cases.is_empty() {
        bail!(
            "no case holds \"{}\"; words of labels like \"single backlash:C white 0.5\" are allowed, with {} or {}",
            args.only,
            visible.catalogued.join(", "),
            visible.uncatalogued.join(", ")
        );
    }
    let singles: Vec<Case> = cases.iter().filter(|case| case.group == Group::Single).cloned().collect();
    let coverage = in_parallel(&singles, "intervals", |case| coverage::cover(&stage, case));
    let trials: Vec<Trial> = if args.coverage_only {
        Vec::new()
    } else {
        let ask = |case: &Case| -> anyhow::Result<Trial> {
            let (staged, trial) = trial::run(&stage, case);
            if let Some(folder) = &args.export {
                export::write(folder, &stage, &staged, &trial)?;
            }
            Ok(trial)
        };
        in_parallel(&cases, "trials", ask).into_iter().collect::<anyhow::Result<_>>()?
    };
    let text = table::document(&args, &visible, &trials, &coverage);
    print!("{text}");
    if args.verbose {
        print!("\n{}{}", table::failures(&trials), table::missed_intervals(&coverage));
    }
    if let Some(path) = &args.markdown {
        std::fs::write(path, &text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// Results in the order of `items`, whoever was ready first.
fn in_parallel<I: Sync, O: Send>(items: &[I], what: &str, work: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, O)>> = Mutex::new(Vec::with_capacity(items.len()));
    std::thread::scope(|scope| {
        for _ in 0..WORKERS {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(i) else { break };
                    let result = work(item);
                    let mut done = done.lock().expect("no worker panicked");
                    done.push((i, result));
                    if done.len().is_multiple_of(PROGRESS) {
                        eprintln!("{} of {} {what}", done.len(), items.len());
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().expect("no worker panicked");
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result).collect()
}
