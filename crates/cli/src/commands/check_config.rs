//! `trunnion check-config`: every problem of the configuration and the files it names, before anything runs.

use crate::commands::daemon::prepare;
use crate::outcome::Outcome;
use crate::terminal;
use std::path::PathBuf;

/// Check a configuration and the files it names
///
/// Example: trunnion check-config config/trunnion.toml
#[derive(clap::Args)]
pub struct Args {
    /// Configuration file
    #[arg(value_name = "FILE", default_value = "config/trunnion.toml")]
    config: PathBuf,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let prepared = prepare(&args.config)?;
    trunnion_service::live::check(&prepared.plan)?;
    let (machine, cycle) = (&prepared.plan.machine.name, &prepared.plan.cycle.name);
    let devices = prepared.config.devices.len();
    terminal::print(&format!(
        "{}: good; machine {machine}, cycle {cycle}, {devices} devices\n",
        args.config.display()
    ))?;
    Ok(Outcome::Done)
}
