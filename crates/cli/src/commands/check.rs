//! `trunnion check`: can these recordings be what they say they are?

use crate::load::{Loaded, RunArgs};
use crate::outcome::Outcome;
use crate::{load, terminal};
use trunnion::report::check_text;

/// Check whether recordings are plausible before any physics is blamed
///
/// Axes must follow the ball, readings must belong to the positions, and times and directions to the order of the points. What
/// does not fit is tried as a named mistake: swapped or reversed axes, units, setups, probes. Every command that
/// judges a recording asks this first; exit code 3 when something is not plausible or not whole.
///
/// Example: trunnion check run.mcap
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    runs: RunArgs,
    /// Print JSON (format trunnion-check/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let Loaded { experiment, outcome } = load::runs(&args.runs)?;
    let check = experiment.check();
    if args.json {
        terminal::print_json(&check)?;
    } else {
        terminal::print(&check_text(&check))?;
    }
    Ok(if check.plausibility.is_empty() { outcome } else { outcome.or_withheld() })
}
