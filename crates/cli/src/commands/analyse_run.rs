//! `trunnion analyse-run`: what the service starts for each recording, a process of its own. Not for a person.

use super::daemon::log_to_stderr;
use crate::outcome::Outcome;
use crate::terminal;
use anyhow::Context;
use std::path::PathBuf;
use trunnion::Model;
use trunnion::results::{Verdict, to_json_line};
use trunnion_service::child;
use trunnion_service::daemon::{self, Report};

/// Analyse a recording and write its report next to it; the answer in short goes to standard output
///
/// Example: trunnion analyse-run run.mcap --date 2026-11-23 --memory-mb 4096
#[derive(clap::Args)]
pub struct Args {
    /// Recording
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Model file; the base model without it
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Date of what is added
    #[arg(long)]
    date: String,
    /// Memory that it may take
    #[arg(long)]
    memory_mb: f64,
    /// End when standard input ends
    #[arg(long)]
    with_parent: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    log_to_stderr();
    if args.with_parent {
        child::end_with_parent();
    }
    child::limit_memory(args.memory_mb).context("cannot limit the memory")?;
    let model = args.model.as_ref().map(Model::load).transpose()?;
    let Report { answer, .. } = daemon::write_report(&args.run, model.as_ref(), &args.date)?;
    terminal::print_verbatim(&to_json_line(&answer)?)?;
    Ok(match answer.result.verdict {
        Verdict::NotJudged => Outcome::Withheld,
        _ => Outcome::Done,
    })
}
