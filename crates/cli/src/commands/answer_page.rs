//! `trunnion answer-page`: what a page starts to analyse the recordings that are looked at. Not for a person.

use super::daemon::log_to_stderr;
use crate::outcome::Outcome;
use anyhow::Context;
use trunnion_service::{child, page};

/// Answer questions about recordings: one a line on standard input, until it ends
///
/// Example: trunnion answer-page --memory-mb 4096
#[derive(clap::Args)]
pub struct Args {
    /// Memory that it may take
    #[arg(long)]
    memory_mb: f64,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    log_to_stderr();
    child::limit_memory(args.memory_mb).context("cannot limit the memory")?;
    page::answer_questions(std::io::stdout().lock()).context("cannot write an answer")?;
    Ok(Outcome::Done)
}
