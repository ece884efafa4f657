//! `trunnion join`: parts of one cycle as one recording.

use crate::outcome::Outcome;
use crate::{load, terminal};
use std::path::PathBuf;
use trunnion::results::Joined;

/// Join recordings of one cycle that was recorded in parts
///
/// The samples of all parts are put on one time and the points formed from them again; what lies between is a gap. The parts stay as
/// they are. The service does this by itself where it was started again while the program ran.
///
/// Example: trunnion join part-1.mcap part-2.mcap -o cycle.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Recordings, in order of time
    #[arg(value_name = "RUN", required = true, num_args = 2..)]
    runs: Vec<PathBuf>,
    /// The recording to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    args.runs.iter().try_for_each(|path| load::no_points_file(path))?;
    let joined = trunnion::join::join(&args.runs, &args.output)?;
    if args.json {
        terminal::print_json(&joined)?;
    } else {
        terminal::print(&text(&joined))?;
    }
    Ok(Outcome::Done)
}

fn text(joined: &Joined) -> String {
    let lines = joined.parts.iter().map(|part| {
        format!("{:10.1} to {:.1} s   {} readings   {}\n", part.from_s, part.to_s, part.read, part.run)
    });
    lines.chain([format!("{}: {} readings\n", joined.run, joined.read)]).collect()
}
