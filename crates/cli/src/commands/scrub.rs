//! `trunnion scrub`: passwords out of recordings that older versions made.

use crate::outcome::Outcome;
use crate::{load, terminal};
use std::path::PathBuf;
use trunnion::gaps::Missing;
use trunnion::results::{Scrubbed, ScrubbedRecording};

/// Leave passwords out of recordings of older versions
///
/// Recordings of this version hold none: values of keys like `password`, users and passwords in addresses, and comments that speak of
/// them are left out of the configuration that is recorded. A recording that holds some is copied without them; the copy takes
/// its place once it reads back message by message.
///
/// Example: trunnion scrub recordings/*.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Recordings
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let scrubbed: Result<Vec<_>, _> = args.runs.iter().map(|run| trunnion::tables::scrub(run)).collect();
    let scrubbed = Scrubbed { recordings: scrubbed?, ..Scrubbed::default() };
    if args.json {
        terminal::print_json(&scrubbed)?;
    } else {
        scrubbed.recordings.iter().try_for_each(|recording| terminal::print(&line(recording)))?;
    }
    let damaged =
        |recording: ScrubbedRecording| recording.damage.map(|damage| format!("{}: {damage}", recording.run));
    let damage = scrubbed.recordings.into_iter().find_map(damaged);
    Ok(load::outcome(&Missing { damage, ..Missing::default() }))
}

fn line(recording: &ScrubbedRecording) -> String {
    let what = match recording.changed {
        true => "passwords were left out",
        false => "holds no password",
    };
    format!("{}: {what}\n", recording.run)
}
