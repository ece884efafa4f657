//! `trunnion replay`: the analysis of a recording once more, from the file alone.

use super::progress_bar::ProgressBar;
use crate::load::{Loaded, ModelArgs};
use crate::outcome::Outcome;
use crate::{load, output, terminal};
use anyhow::Context;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use trunnion::Form;
use trunnion::replay::{Happened, replay};
use trunnion::results::to_json;

/// Analyse a recording again; writes the same bytes as the live run did
///
/// With --form its points are formed from the samples again, by other settings of its cycle or other directions of its nest. With
/// --speed the cycle is first gone through in its own time: points, events and gaps are shown when they came.
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
    /// Show the cycle first, so many times as fast as it was measured
    #[arg(long, value_name = "X", value_parser = speed)]
    speed: Option<f64>,
    /// Folder for NAME.identification.json and NAME.diagnosis.json; without it, standard output
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> anyhow::Result<Outcome> {
    let form = Form::parse(&args.form)?;
    if let Some(speed) = args.speed {
        load::no_points_file(&args.run)?;
        show(&args.run, &form, speed)?;
    }
    let Loaded { experiment, outcome } = match args.form.is_empty() {
        true => load::runs(&load::RunArgs::of(vec![args.run.clone()]))?,
        false => load::formed(&args.run, &form)?,
    };
    let model = args.model.model(&experiment)?;
    let analysed = experiment.analyse(&model, "")?;
    analysed.left_out().iter().for_each(|left_out| terminal::remark(left_out));
    let identification = to_json(&analysed.before().identified())?;
    let first = analysed.first().results();
    let outcome = outcome.with_verdict(first.verdict);
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

fn speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if (0.01..=1e6).contains(&speed) => Ok(speed),
        _ => Err("allowed: 0.01..=1000000".into()),
    }
}

/// Goes through the recording; what was said live stands on standard error.
fn show(run: &Path, form: &Form, speed: f64) -> anyhow::Result<()> {
    let begun = Instant::now();
    let mut bar = ProgressBar::new(false);
    replay(run, form, &mut |moment| {
        let due = Duration::from_secs_f64(moment.time_s.max(0.0) / speed);
        // The recording has its own pace, at the speed that was asked for.
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
        let said = match moment.what {
            Happened::Samples => return true,
            Happened::Point(_) => None,
            Happened::Event(event) => Some(format!("{}: {}", event.kind, event.text)),
            Happened::Gap(gap) => {
                let lasted_s = gap.to_s - gap.from_s;
                Some(format!("{}: nothing for {lasted_s:.2} s: {}", gap.source, gap.reason))
            }
        };
        if let Some(said) = said {
            bar.clear();
            terminal::remark(&format!("{:.1} s: {said}", moment.time_s));
        }
        bar.show(moment.progress);
        true
    })?;
    bar.clear();
    Ok(())
}
