//! `trunnion import`: points measured elsewhere become a recording.

use crate::outcome::Outcome;
use crate::terminal;
use std::path::PathBuf;
use trunnion::cycles::RunKind;
use trunnion::results::Imported;
use trunnion_core::number::counted;

/// Import a points file (points.csv with setup.toml) as a recording
///
/// With --kind on-the-fly the rows are samples of axes in motion, in order of time. Such a table may also state the feed
/// (feed_mm_per_min) and what the encoders read (x_actual_mm, c_actual_deg, spindle_deg). It may state speeds (c_speed_deg_per_s) and
/// accelerations. What it does not state follows from the positions.
///
/// Example: trunnion import points.csv --setup setup.toml -o run.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Points file
    #[arg(value_name = "POINTS.CSV")]
    points: PathBuf,
    /// Setup file; without it, setup.toml next to the points
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,
    /// How the points were measured: with all axes at rest, or on the fly
    #[arg(long, value_name = "KIND", default_value = "static", value_parser = ["static", "on-the-fly"])]
    kind: String,
    /// Recording to write
    #[arg(short, long, value_name = "RUN.MCAP")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    if args.points.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("b5r")) {
        let path = args.points.display();
        anyhow::bail!(
            "{path} is the result file of a ball bar, not a table of points: no public document names its readings. To see its numbers next to yours, use \
             `trunnion identify RUN.MCAP --method circular --against {path}`"
        );
    }
    let setup_path = args.setup.clone().unwrap_or_else(|| args.points.with_file_name("setup.toml"));
    let kind = if args.kind == "static" { RunKind::Static } else { RunKind::OnTheFly };
    let (run, points) = trunnion::tables::import(kind, &args.points, &setup_path, &args.output)?;
    if args.json {
        terminal::print_json(&Imported {
            run: args.output.display().to_string(),
            points,
            setups: run.setups.len(),
            machine: run.machine.name,
        })?;
    } else {
        let (points, setups) = (counted(points, "point"), counted(run.setups.len() as u64, "setup"));
        terminal::print(&format!("{points} of {setups} -> {}\n", args.output.display()))?;
    }
    Ok(Outcome::Done)
}
