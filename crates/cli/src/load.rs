//! Runs and models from the paths a user gives.

use crate::outcome::Outcome;
use crate::terminal;
use anyhow::bail;
use std::path::{Path, PathBuf};
use trunnion::gaps::Missing;
use trunnion::results::Plausibility;
use trunnion::{Experiment, Form, Limits, Model};
use trunnion_service::run_record;

pub use trunnion::files::{machine_in, machine_text, read};

/// Most blocks that may be asked for.
const MOST_BLOCKS: usize = 20_000;

/// Recordings named on a command line.
#[derive(clap::Args)]
pub struct RunArgs {
    /// Recordings (.mcap); several are fitted together
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// A run on the fly with more samples than this is reduced to at most as many blocks [default: 2000; 20000 with --method]
    #[arg(long, value_name = "N", value_parser = blocks)]
    pub blocks: Option<usize>,
}

impl RunArgs {
    /// The files that are read.
    pub fn paths<'a>(&'a self, model: &'a ModelArgs) -> impl Iterator<Item = &'a Path> + Clone {
        self.runs.iter().chain(&model.model).map(PathBuf::as_path)
    }

    /// These recordings with the usual number of blocks.
    pub fn of(runs: Vec<PathBuf>) -> Self {
        Self { runs, blocks: None }
    }
}

/// Recordings that a person acts on: an effect enters the model, a table the control, a cycle the machine.
#[derive(clap::Args)]
pub struct TrustedArgs {
    #[command(flatten)]
    pub runs: RunArgs,
    /// Go on although the runs are not plausible or not whole
    #[arg(long)]
    pub anyway: bool,
}

fn blocks(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 50..=MOST_BLOCKS) => Ok(count),
        _ => Err("allowed: 50..=20000".into()),
    }
}

/// The model a command judges.
#[derive(Clone, clap::Args)]
pub struct ModelArgs {
    /// Model file; without it the base model (location errors and ball setting)
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
}

/// Opened recordings.
pub struct Loaded {
    /// Their runs.
    pub experiment: Experiment,
    /// Whether something of them is lost.
    pub outcome: Outcome,
}

impl Loaded {
    /// How a command ends that shows numbers of these runs, and its doubts with them.
    pub fn judgement(&self) -> Outcome {
        if self.experiment.plausibility().is_empty() { self.outcome } else { self.outcome.or_withheld() }
    }

    /// The same for a command whose answer has no room for doubts: they go to standard error.
    pub fn stated_judgement(&self) -> Outcome {
        self.experiment.plausibility().iter().for_each(|doubt| terminal::remark(&sentence(doubt)));
        self.judgement()
    }
}

fn sentence(doubt: &Plausibility) -> String {
    format!("{} {}", doubt.finding, doubt.hypothesis)
}

/// Runs that were not acted on.
#[derive(Debug, thiserror::Error)]
#[error(
    "nothing was done, because the runs are not plausible or not whole: {0} `--anyway` goes on all the same"
)]
pub struct NotTrusted(String);

/// Opens recordings that a person acts on.
///
/// # Errors
/// [`NotTrusted`] where they are not plausible or not whole and `anyway` is not given.
pub fn trusted_runs(args: &TrustedArgs) -> anyhow::Result<Loaded> {
    let loaded = runs(&args.runs)?;
    let doubts: Vec<String> = loaded.experiment.plausibility().iter().map(sentence).collect();
    if !doubts.is_empty() && !args.anyway {
        return Err(NotTrusted(doubts.join(" ")).into());
    }
    let outcome = loaded.stated_judgement();
    Ok(Loaded { outcome, ..loaded })
}

/// Opens the recordings; those taken on the fly with more samples than `--blocks` are reduced to blocks while they are read.
/// Damage and gaps are reported on standard error and end in [`Outcome::DataLoss`].
pub fn runs(args: &RunArgs) -> anyhow::Result<Loaded> {
    reduced_runs(args, Limits::default().most_blocks)
}

/// The same for a named method, which looks at single turns of an axis: as fine as blocks can be.
pub fn runs_for_method(args: &RunArgs) -> anyhow::Result<Loaded> {
    reduced_runs(args, MOST_BLOCKS)
}

fn reduced_runs(args: &RunArgs, usual_blocks: usize) -> anyhow::Result<Loaded> {
    let limits = Limits { most_blocks: args.blocks.unwrap_or(usual_blocks), ..Limits::default() };
    args.runs.iter().try_for_each(|path| no_points_file(path))?;
    Ok(stated(trunnion::open_with(&args.runs, limits)?))
}

/// Opens a recording with its points formed again from its samples.
pub fn formed(run: &Path, form: &Form) -> anyhow::Result<Loaded> {
    no_points_file(run)?;
    Ok(stated(trunnion::open_formed(run, Limits::default(), form)?))
}

/// What was opened, with its reductions, damage and gaps on standard error.
fn stated(experiment: Experiment) -> Loaded {
    experiment.reductions().iter().chain(&experiment.damage()).for_each(|text| terminal::remark(text));
    state_gaps(&experiment.gaps());
    let outcome = if experiment.losses().is_empty() { Outcome::Done } else { Outcome::DataLoss };
    Loaded { experiment, outcome }
}

fn state_gaps(gaps: &[String]) {
    match gaps {
        [] => {}
        [gap] => terminal::remark(gap),
        [first, further @ ..] => terminal::remark(&format!("{first}; {} further losses", further.len())),
    }
}

/// What the service kept of each recording's losses (`NAME.state.json`), some of which no recording says; with the run where there are
/// several.
pub fn kept_losses(recordings: &[PathBuf]) -> Vec<String> {
    let of = |recording: &PathBuf| {
        let run = recording.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let named = move |loss| if recordings.len() == 1 { loss } else { format!("{run}: {loss}") };
        run_record::read(recording).unwrap_or_default().losses.into_iter().map(named)
    };
    recordings.iter().flat_map(of).collect()
}

/// Reports what is missing from a recording on standard error; how a command ends that did all else.
pub fn outcome(missing: &Missing) -> Outcome {
    missing.damage.iter().for_each(|damage| terminal::remark(damage));
    state_gaps(&missing.gaps);
    if *missing == Missing::default() { Outcome::Done } else { Outcome::DataLoss }
}

/// Commands take recordings, which hold what a points file lacks: where it came from, and with which version it was read.
pub fn no_points_file(path: &Path) -> anyhow::Result<()> {
    if path.extension().is_some_and(|ending| ending == "csv") {
        bail!(
            "{} is a points file; import it first: trunnion import {0} --setup setup.toml -o run.mcap",
            path.display()
        );
    }
    if is_model_file(path) {
        bail!("{} is a model file, no recording; a model file goes with --model", path.display());
    }
    Ok(())
}

/// One that does not read as a model is refused as what it is not: a recording.
fn is_model_file(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "toml") && Model::load(path).is_ok()
}

impl ModelArgs {
    /// The model to judge the runs by.
    pub fn model(&self, experiment: &Experiment) -> anyhow::Result<Model> {
        Ok(match &self.model {
            None => experiment.base_model(),
            Some(path) => Model::load(path)?,
        })
    }

    /// The same for a command whose answer has no room for doubts: one of the file goes to standard error.
    pub fn stated_model(&self, experiment: &Experiment) -> anyhow::Result<Model> {
        let model = self.model(experiment)?;
        if let Some(doubt) = model.doubt_for(&experiment.machine().name) {
            terminal::remark(&doubt.words);
        }
        Ok(model)
    }
}
