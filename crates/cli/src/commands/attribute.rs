//! `trunnion attribute`: which axis made the deviation, from the axes' own encoders.

use crate::outcome::Outcome;
use crate::{load, output};
use std::path::PathBuf;
use trunnion::Attributed;

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
    output::not_an_input(&[("--html", args.html.as_deref())], [args.run.as_path()])?;
    let Attributed { findings, missing } = trunnion::attribute_run(&args.run, args.knot_s, args.smooth)?;
    let outcome = load::outcome(&missing);
    output::findings(&findings, args.html.as_deref(), args.json)?;
    Ok(if findings.plausibility.is_empty() { outcome } else { outcome.or_withheld() })
}
