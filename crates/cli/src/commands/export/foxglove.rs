//! A recording for 3D viewers.

use super::request::{Format, Request};
use crate::load::{self, RunArgs};
use crate::outcome::Outcome;
use crate::{output, terminal};
use anyhow::{Context, bail};
use std::path::Path;
use trunnion::gaps::Missing;
use trunnion::{Fit, foxglove};

pub const FORMAT: Format = Format { name: "foxglove", run };

fn run(request: &Request) -> anyhow::Result<Outcome> {
    let [run] = &request.runs[..] else {
        bail!("foxglove is a file of one recording, and {} are named", request.runs.len())
    };
    if let Some(what) = &request.what {
        bail!("foxglove draws the whole recording; --what {what} is for tables");
    }
    let Some(path) = &request.output else { bail!("foxglove is no text; name the file with -o FILE") };
    // A recording that no model fits still shows how the machine moved.
    let fitted =
        fit(request, run).inspect_err(|failure| terminal::remark(&format!("no arrows: {failure:#}")));
    let (fit, of_fit) = fitted.map_or((None, Outcome::DataLoss), |(fit, outcome)| (Some(fit), outcome));
    let written = foxglove::export(run, path, fit.as_ref(), request.magnification)?;
    let layout = path.with_extension("layout.json");
    output::write(&layout, foxglove::LAYOUT)?;
    let arrows = written.magnification.map_or_else(
        || "without arrows".to_owned(),
        |times| format!("arrows of measured errors and residuals, magnification {times:.0}"),
    );
    terminal::print(&format!("{}: {arrows}; layout: {}\n", path.display(), layout.display()))?;
    // Gaps are those of the fit.
    let damaged = Missing { damage: written.damage, ..Missing::default() };
    Ok(match load::outcome(&damaged) {
        Outcome::Done => of_fit,
        lost => lost,
    })
}

fn fit(request: &Request, run: &Path) -> anyhow::Result<(Fit, Outcome)> {
    let loaded = load::runs(&RunArgs::of(vec![run.into()]))?;
    let fit = loaded
        .experiment
        .fit(&request.model.stated_model(&loaded.experiment)?)
        .context("the model does not fit")?;
    Ok((fit, loaded.stated_judgement()))
}
