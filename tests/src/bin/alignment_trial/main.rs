//! `alignment-trial`: how well samples are known in time, against the simulator's truth, for each transport.
//!
//! All devices run at once through real ports, and the real drivers read them. The host's clock is the simulator's time,
//! so the error of every sample is known: stamped on arrival, by the line as it goes, by the line of the whole run, and with
//! the delay of the sync gestures taken out. Writes docs/alignment.md. Run it on a computer with nothing else to do:
//! the jitter of a busy one is in the figures.

mod errors;
mod floor;
mod table;
mod world;

use anyhow::Context;
use clap::Parser;
use std::path::PathBuf;

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

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let args = Args::parse();
    let messages = floor::run(args.seconds).await?;
    let streams = errors::of(&messages, args.seconds);
    let page = table::page(&streams, args.seconds);
    match &args.output {
        Some(path) => std::fs::write(path, page).with_context(|| format!("cannot write {}", path.display())),
        None => {
            print!("{page}");
            Ok(())
        }
    }
}
