//! `trunnion attribute`: which axis made the deviation, from the axes' own encoders.

use crate::outcome::Outcome;
use crate::{load, terminal};
use anyhow::Context;
use std::path::PathBuf;
use trunnion_cycles::Cycle;
use trunnion_methods::attribution::{Motion, attribute};
use trunnion_report::{findings_html, findings_text};

/// Find out which axis made the deviation of a recording on the fly
///
/// The measured motion of one axis is replaced by its ideal motion, all others stay as measured: what disappears at the tool
/// point is that axis' share. Any machine, in series or with parallel legs. The ideal motion comes from the cycle stored in the
/// recording, else from a smooth path through each axis' positions; the output says which.
///
/// Example: trunnion attribute run.mcap --html attribution.html
#[derive(clap::Args)]
pub struct Args {
    /// Recording (.mcap) that holds axis positions
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Distance of the knots of a smooth path, s; what lasts longer passes for the path
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    knot_s: f64,
    /// Judge by a smooth path although the recording holds its cycle
    #[arg(long)]
    smooth: bool,
    /// Write a self-contained page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON (format trunnion-findings/1)
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let recording = trunnion_record::read_run(&args.run, &|name| load::machine(name).ok())
        .with_context(|| format!("cannot read the recording {}", args.run.display()))?;
    let mut outcome = Outcome::Done;
    if let Some(damage) = &recording.damage {
        terminal::remark(&format!("{}: {damage}", args.run.display()));
        outcome = Outcome::DataLoss;
    }
    let text = &recording.header.cycle_text;
    let cycle = if text.is_empty() || args.smooth {
        None
    } else {
        Some(Cycle::parse(&format!("the cycle in {}", args.run.display()), text)?)
    };
    let attribution = attribute(&Motion {
        run: &recording.run.name,
        machine: &recording.run.machine,
        samples: &recording.axis_samples,
        cycle: cycle.as_ref(),
        knot_s: args.knot_s,
    })?;
    let findings = attribution.to_findings();
    if let Some(path) = &args.html {
        std::fs::write(path, findings_html(&findings, &trunnion::page::label()))
            .with_context(|| format!("cannot write {}", path.display()))?;
    }
    if args.json {
        terminal::print_json(&findings.to_json())?;
    } else {
        terminal::print(&findings_text(&findings))?;
        if let Some(path) = &args.html {
            terminal::print(&format!("page: {}\n", path.display()))?;
        }
    }
    Ok(outcome)
}
