//! `trunnion import`: static points measured elsewhere become a recording.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;

/// Import a points file (points.csv with setup.toml) as a recording
///
/// Example: trunnion import points.csv --setup setup.toml -o run.mcap
#[derive(clap::Args)]
pub struct Args {
    /// Points file
    #[arg(value_name = "POINTS.CSV")]
    points: PathBuf,
    /// Setup file; without it, setup.toml beside the points
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,
    /// Recording to write
    #[arg(short, long, value_name = "RUN.MCAP")]
    output: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let setup_path = args.setup.clone().unwrap_or_else(|| args.points.with_file_name("setup.toml"));
    let (setup_text, points_text) = (load::read(&setup_path)?, load::read(&args.points)?);
    let name =
        args.output.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy().into_owned());
    let run = trunnion_record::points_csv::import_files(
        &name,
        (&args.points.display().to_string(), &points_text),
        (&setup_path.display().to_string(), &setup_text),
        &|machine| load::machine(machine).ok(),
    )?;
    let setup = trunnion_core::setup::parse_setup_file(&setup_path.display().to_string(), &setup_text)?;
    let machine_text = load::machine_text(&setup.machine)?;
    let header = trunnion_record::RunHeader::of_run(&run, &machine_text, env!("CARGO_PKG_VERSION"), 0);
    trunnion_record::write_run(&args.output, &header, &run)
        .with_context(|| format!("cannot write {}", args.output.display()))?;
    if args.json {
        let summary = serde_json::json!({ "run": args.output.display().to_string(), "points": run.points.len(),
            "setups": run.setups.len(), "machine": run.machine.name });
        terminal::print_json(&summary)?;
    } else {
        let (points, setups) = (run.points.len(), run.setups.len());
        terminal::print(&format!("{points} points of {setups} setups -> {}\n", args.output.display()))?;
    }
    Ok(Outcome::Done)
}
