//! `trunnion ladder`: the effects added so far, with the error after each.

use crate::outcome::Outcome;
use crate::{output, terminal};
use std::path::PathBuf;
use trunnion::Model;
use trunnion::report::{ladder_html, ladder_text};

/// Show the effects added to a model, with the error after each
///
/// Example: trunnion ladder --model machine.model.toml --html ladder.html
#[derive(clap::Args)]
pub struct Args {
    /// Model file
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// Write a self-contained page with the chart
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    output::not_an_input(&[("--html", args.html.as_deref())], [args.model.as_path()])?;
    let model = Model::load(&args.model)?;
    let ladder = model.ladder();
    if let Some(path) = &args.html {
        output::write(path, &ladder_html(&model.entries().machine, &ladder))?;
    }
    if args.json {
        terminal::print_json(&ladder)?;
    } else {
        terminal::print(&ladder_text(&ladder, None))?;
        if let Some(path) = &args.html {
            terminal::print(&format!("page: {}\n", path.display()))?;
        }
    }
    Ok(Outcome::Done)
}
