//! Machines, runs and models from the names and paths a user gives.

use crate::outcome::Outcome;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use trunnion_effects::Model;
use trunnion_identify::{Experiment, Nominal};
use trunnion_machine::{Machine, shipped};
use trunnion_measurement::blocks::{Limits, Reducer, Reduction};
use trunnion_measurement::{Point, Run, RunKind};
use trunnion_record::{Damage, RecordError, RunStart};

/// Recordings named on a command line.
#[derive(clap::Args)]
pub struct RunArgs {
    /// Recordings (.mcap); several are fitted together
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// A run on the fly with more samples than this is reduced to at most as many blocks
    #[arg(long, value_name = "N", default_value_t = Limits::default().most_blocks, value_parser = blocks)]
    pub blocks: usize,
}

/// Points in one batch between the threads, and batches waiting.
const BATCH: usize = 256;
const QUEUE: usize = 16;

impl RunArgs {
    /// These recordings with the usual number of blocks.
    pub fn of(runs: Vec<PathBuf>) -> Self {
        Self { runs, blocks: Limits::default().most_blocks }
    }
}

fn blocks(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 50..=20_000) => Ok(count),
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
        let names = shipped::FILES.map(|(name, _)| name).join(", ");
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

/// Reads the recordings; those taken on the fly with more samples than `--blocks` are reduced to blocks while they are read.
/// Damage is told on standard error and ends in [`Outcome::DataLoss`].
pub fn runs(args: &RunArgs) -> anyhow::Result<(Vec<Run>, Outcome)> {
    let limits = Limits { most_blocks: args.blocks, ..Limits::default() };
    let mut outcome = Outcome::Done;
    let mut runs = Vec::new();
    for path in &args.runs {
        let (run, reduction, one) = read_in_two_threads(path, Some(limits))?;
        if let Some(reduction) = reduction {
            eprintln!("trunnion: {}: {}", path.display(), reduction.summary());
        }
        runs.push(run);
        if one == Outcome::DataLoss {
            outcome = one;
        }
    }
    Ok((runs, outcome))
}

/// Reads one recording with every point as recorded.
pub fn run(path: &Path) -> anyhow::Result<(Run, Outcome)> {
    let (run, _, outcome) = read_in_two_threads(path, None)?;
    Ok((run, outcome))
}

/// One thread unpacks the file, the other reduces; at most [`QUEUE`] batches wait between them.
fn read_in_two_threads(
    path: &Path,
    limits: Option<Limits>,
) -> anyhow::Result<(Run, Option<Reduction>, Outcome)> {
    if path.extension().is_some_and(|ending| ending == "csv") {
        bail!(
            "{} is a points file; import it first: trunnion import {0} --setup setup.toml -o run.mcap",
            path.display()
        );
    }
    let (send, batches) = mpsc::sync_channel::<Batch>(QUEUE);
    let mut points = Points { limits, kept: Vec::new(), reducer: None };
    let read = std::thread::scope(|scope| {
        let unpack = scope.spawn(move || unpack(path, &send));
        batches.into_iter().for_each(|batch| points.take(batch));
        unpack.join().expect("a panic of the reading thread ends the program")
    });
    let (start, damage) = read.with_context(|| format!("cannot read the recording {}", path.display()))?;
    let mut outcome = Outcome::Done;
    if let Some(damage) = &damage {
        eprintln!("trunnion: {}: {damage}", path.display());
        outcome = Outcome::DataLoss;
    }
    let (points, reduction) = points.finish();
    Ok((start.run(points), reduction, outcome))
}

/// Points on their way from the file; the first batch says what run they are of.
struct Batch {
    start: Option<RunStart>,
    points: Vec<(u64, Point)>,
}

fn unpack(path: &Path, send: &mpsc::SyncSender<Batch>) -> Result<(RunStart, Option<Damage>), RecordError> {
    let mut batch = Batch { start: None, points: Vec::with_capacity(BATCH) };
    let mut first = true;
    let hand_over = |batch| send.send(batch).expect("batches are taken until the end of the file");
    let read =
        trunnion_record::visit_points(path, &|name| machine(name).ok(), &mut |start, index, point| {
            if std::mem::take(&mut first) {
                batch.start = Some(start.clone());
            }
            batch.points.push((index, point));
            if batch.points.len() == BATCH {
                let next = Batch { start: None, points: Vec::with_capacity(BATCH) };
                hand_over(std::mem::replace(&mut batch, next));
            }
        })?;
    hand_over(batch);
    Ok(read)
}

/// Points of a run as they are read: kept, or reduced to blocks when they are many and were taken on the fly.
struct Points {
    limits: Option<Limits>,
    kept: Vec<(u64, Point)>,
    reducer: Option<(RunStart, Option<Reducer<Nominal>>)>,
}

impl Points {
    fn take(&mut self, batch: Batch) {
        if let Some(start) = batch.start {
            self.reducer = Some((start, None));
        }
        for (index, point) in batch.points {
            match &mut self.reducer {
                Some((_, Some(reducer))) => reducer.push(index, point),
                _ => self.kept.push((index, point)),
            }
            if let (Some(limits), Some((start, empty @ None))) = (self.limits, &mut self.reducer)
                && start.header.kind == RunKind::OnTheFly
                && self.kept.len() > limits.most_blocks
            {
                let mut reducer = trunnion_identify::reducer(&start.machine, &start.header.setups, limits);
                self.kept.drain(..).for_each(|(index, point)| reducer.push(index, point));
                *empty = Some(reducer);
            }
        }
    }

    fn finish(mut self) -> (Vec<Point>, Option<Reduction>) {
        if let Some((_, Some(reducer))) = self.reducer {
            let mut reduction = reducer.finish();
            return (std::mem::take(&mut reduction.points), Some(reduction));
        }
        self.kept.sort_by_key(|(index, _)| *index);
        (self.kept.into_iter().map(|(_, point)| point).collect(), None)
    }
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

/// Reads a model file.
pub fn model(path: &Path) -> anyhow::Result<Model> {
    Ok(Model::parse(&path.display().to_string(), &read(path)?)?)
}
