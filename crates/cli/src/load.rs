//! Machines, runs and models from the names and paths a user gives.

use crate::outcome::Outcome;
use crate::terminal;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use trunnion::recording;
use trunnion::recording::Recording;
use trunnion_core::names;
use trunnion_cycles::Run;
use trunnion_effects::Model;
use trunnion_engine::Experiment;
use trunnion_machine::{Machine, shipped};
use trunnion_sync::blocks::Limits;
use trunnion_sync::time_quality::TimeQuality;

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
    /// These recordings with the usual number of blocks.
    pub fn of(runs: Vec<PathBuf>) -> Self {
        Self { runs, blocks: None }
    }
}

fn blocks(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 50..=MOST_BLOCKS) => Ok(count),
        _ => Err("allowed: 50..=20000".into()),
    }
}

/// The model a command judges.
#[derive(clap::Args)]
pub struct ModelArgs {
    /// Model file; without it the base model (location errors and ball setting)
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
}

/// A machine file by path, or a shipped machine by name.
pub fn machine(name: &str) -> anyhow::Result<Machine> {
    let path = Path::new(name);
    if path.extension().is_some_and(|ending| ending == "toml") {
        let text = read(path)?;
        let stem = path.file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        return Ok(Machine::parse(&stem, name, &text)?);
    }
    shipped::machine(name).with_context(|| {
        let names = names::allowed(name, shipped::FILES.map(|(name, _)| name));
        format!(
            "there is no machine \"{name}\"; allowed: {names}, or the path of a machine file ending in .toml"
        )
    })
}

/// The text of a machine by the name or path in a file, for the recording.
pub fn machine_text(name: &str) -> anyhow::Result<String> {
    match shipped::FILES.iter().find(|(shipped, _)| *shipped == name) {
        Some((_, text)) => Ok((*text).into()),
        None => read(Path::new(name)),
    }
}

/// Reads a text file; the error names it.
pub fn read(path: &Path) -> anyhow::Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Recordings as read.
pub struct Loaded {
    /// Their points, or blocks of them.
    pub runs: Vec<Run>,
    /// Whether something of them is lost.
    pub outcome: Outcome,
    /// How well those with stamps are known in time.
    pub timing: Vec<TimeQuality>,
}

/// Reads the recordings; those taken on the fly with more samples than `--blocks` are reduced to blocks while they are read.
/// Damage is told on standard error and ends in [`Outcome::DataLoss`].
pub fn runs(args: &RunArgs) -> anyhow::Result<Loaded> {
    reduced_runs(args, Limits::default().most_blocks)
}

/// The same for a named method, which looks at single turns of an axis: as fine as blocks can be.
pub fn runs_for_method(args: &RunArgs) -> anyhow::Result<Loaded> {
    reduced_runs(args, MOST_BLOCKS)
}

fn reduced_runs(args: &RunArgs, usual_blocks: usize) -> anyhow::Result<Loaded> {
    let limits = Limits { most_blocks: args.blocks.unwrap_or(usual_blocks), ..Limits::default() };
    let mut loaded = Loaded { runs: Vec::new(), outcome: Outcome::Done, timing: Vec::new() };
    for path in &args.runs {
        let (recording, outcome) = read_one(path, Some(limits))?;
        if let Some(reduction) = &recording.reduction {
            terminal::remark(&format!("{}: {}", path.display(), reduction.summary()));
        }
        loaded.runs.push(recording.run);
        loaded.timing.extend(recording.timing);
        if outcome == Outcome::DataLoss {
            loaded.outcome = outcome;
        }
    }
    Ok(loaded)
}

/// Reads one recording with every point.
pub fn run(path: &Path) -> anyhow::Result<(Run, Outcome)> {
    let (recording, outcome) = read_one(path, None)?;
    Ok((recording.run, outcome))
}

/// Reads one recording and tells its damage.
fn read_one(path: &Path, limits: Option<Limits>) -> anyhow::Result<(Recording, Outcome)> {
    if path.extension().is_some_and(|ending| ending == "csv") {
        bail!(
            "{} is a points file; import it first: trunnion import {0} --setup setup.toml -o run.mcap",
            path.display()
        );
    }
    let recording = recording::read(path, &|name| machine(name).ok(), limits)
        .with_context(|| format!("cannot read the recording {}", path.display()))?;
    let mut outcome = Outcome::Done;
    if let Some(damage) = &recording.damage {
        terminal::remark(&format!("{}: {damage}", path.display()));
        outcome = Outcome::DataLoss;
    }
    Ok((recording, outcome))
}

/// The experiment of the runs and the model to judge it by.
pub fn experiment(runs: &[Run], args: &ModelArgs) -> anyhow::Result<(Experiment, Model)> {
    let experiment = Experiment::new(runs)?;
    let model = match &args.model {
        None => Model::base(&experiment.machine().name),
        Some(path) => model(path)?,
    };
    Ok((experiment, model))
}

/// Adds to the time quality what the sweeps of the experiment tell of delays.
pub fn tell_delay(experiment: &Experiment, timing: &mut [TimeQuality]) -> anyhow::Result<()> {
    if let Some(last) = timing.last_mut() {
        last.notes.extend(trunnion::timing::delay_by_feeds(experiment)?);
    }
    Ok(())
}

/// Reads a model file.
pub fn model(path: &Path) -> anyhow::Result<Model> {
    Ok(Model::parse(&path.display().to_string(), &read(path)?)?)
}
