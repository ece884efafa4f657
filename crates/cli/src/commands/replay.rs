//! `trunnion replay`: the analysis of a recording once more, from the file alone.

use crate::load::{Loaded, ModelArgs};
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::Context;
use std::path::PathBuf;
use trunnion::Form;
use trunnion::results::{Verdict, to_json};

/// Analyse a recording again; writes the same bytes as the live run did
///
/// With --form its points are formed from the samples again, by other settings of its cycle or other directions of its nest.
///
/// Example: trunnion replay run.mcap --output again/ --form settle.window_s=0.3
#[derive(clap::Args)]
pub struct Args {
    /// Recording
    #[arg(value_name = "RUN")]
    run: PathBuf,
    #[command(flatten)]
    model: ModelArgs,
    /// Form the points again with this key of the cycle, or of the nest, changed (may be given several times)
    #[arg(long, value_name = "KEY=VALUE")]
    form: Vec<String>,
    /// Folder for NAME.identification.json and NAME.diagnosis.json; without it, standard output
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let Loaded { experiment, outcome } = match args.form.is_empty() {
        true => load::runs(&load::RunArgs::of(vec![args.run.clone()]))?,
        false => load::formed(&args.run, &Form::parse(&args.form)?)?,
    };
    let model = args.model.model(&experiment)?;
    let analysed = experiment.analyse(&model, "")?;
    let identification = to_json(&analysed.before().results())?;
    let first = analysed.first().results();
    let outcome = if first.verdict == Verdict::NotJudged { Outcome::Withheld } else { outcome };
    let diagnosis = to_json(&first)?;
    let Some(folder) = &args.output else {
        terminal::print_verbatim(&identification)?;
        terminal::print_verbatim(&diagnosis)?;
        return Ok(outcome);
    };
    let name = args.run.file_name().context("the recording has no name")?;
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (ending, text) in [("identification.json", identification), ("diagnosis.json", diagnosis)] {
        let path = folder.join(name).with_extension(ending);
        output::write(&path, &text)?;
        terminal::print(&format!("{}\n", path.display()))?;
    }
    Ok(outcome)
}
