//! `alignment-trial`: how well samples are known in time, against the simulator's truth, for each transport.
//!
//! All devices run at once through real ports, and the real drivers read them. The host's clock is the simulator's time,
//! so the error of every sample is known (`trunnion_tests::alignment`): stamped on arrival, by the line as it goes, by the line of the whole run, and with
//! the delay of the synchronisation moves taken out. Writes docs/measured/alignment.md. Run it on a computer with nothing else to do:
//! the jitter of a busy one is in the figures.

mod devices;
mod floor;
mod page;
mod promise;

use anyhow::Context;
use clap::Parser;
use std::path::PathBuf;
use trunnion_tests::alignment;

/// Alignment error against the simulator's truth
#[derive(Parser)]
struct Args {
    /// Length of the run, s
    #[arg(long, default_value_t = 130.0)]
    seconds: f64,
    /// Where to write the table; standard output without it
    #[arg(long)]
    output: Option<PathBuf>,
}

fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let before = match &args.output {
        Some(path) if path.exists() => {
            std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?
        }
        _ => String::new(),
    };
    let floor = floor::start(args.seconds)?;
    let messages = floor.read()?;
    let truths: Vec<_> = floor.devices.iter().map(|device| device.truth).collect();
    let streams = alignment::of(&messages, &truths, Some(floor.reference), args.seconds);
    let page = page::page(&floor, &streams, args.seconds, &before);
    floor.stop();
    match &args.output {
        Some(path) => std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display())),
        None => {
            print!("{page}");
            Ok(())
        }
    }
}
