//! What can go wrong on the way from a path to an answer; the cause is chained.

use crate::analysis_error::AnalysisError;
use std::path::{Path, PathBuf};
use trunnion_core::Problems;
use trunnion_cycles::VisitError;
use trunnion_engine::next_cycle::PlanError;
use trunnion_engine::{DiagnoseError, ExperimentError, IdentifyError};
use trunnion_record::{RecordError, with_nearest};

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A text file that cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file that cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A file that this program reads, where something else was to be written.
    #[error(
        "{} is {holds}, which would be lost: nothing was written there. Name another file, or remove this one first",
        path.display()
    )]
    WouldBeLost {
        /// The file.
        path: PathBuf,
        /// What it is.
        holds: &'static str,
    },
    /// A correction without who entered it, or what.
    #[error("who entered a correction, and what? each at most {longest} characters")]
    NotSaid {
        /// Most characters.
        longest: usize,
    },
    /// A line that is no correction.
    #[error("{}:{line} is no correction: {why}", path.display())]
    NoCorrectionLine {
        /// The file.
        path: PathBuf,
        /// Number of the line.
        line: usize,
        /// Why.
        why: String,
    },
    /// A recording that cannot be read.
    #[error("cannot read the recording {}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// The cause, which does not name the file again.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// Recordings that are no parts of one cycle.
    #[error("{} was not joined: {why}", path.display())]
    NotJoined {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// The file of another program that says nothing of these runs.
    #[error("{} is no second opinion: {why}", path.display())]
    NoSecondOpinion {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
    /// Problems of a hand-written file, each with line, what was found and what is allowed.
    #[error(transparent)]
    Problems(#[from] Problems),
    /// A machine that is neither shipped nor a file.
    #[error(
        "there is no machine \"{name}\"; allowed: {allowed}, or the path of a machine file ending in .toml"
    )]
    NoSuchMachine {
        /// As asked.
        name: String,
        /// The shipped ones.
        allowed: String,
    },
    /// Nothing that a control could take.
    #[error("nothing was written for the control: {why}")]
    NoCorrection {
        /// Why.
        why: String,
    },
    /// Damaged files that hold nothing more to judge.
    #[error(
        "{losses}. Nothing usable is left of {runs}: copy the file again from where it was recorded, or measure again"
    )]
    NothingLeft {
        /// Names of the runs.
        runs: String,
        /// What is missing, with the files.
        losses: String,
    },
    /// Runs that cannot be fitted together.
    #[error(transparent)]
    Experiment(Box<ExperimentError>),
    /// The fit failed.
    #[error(transparent)]
    Fit(Box<IdentifyError>),
    /// A fit that did not converge to runs that cannot be what they say they are.
    #[error("the model cannot be fitted to these runs. {doubt}")]
    NotPlausible {
        /// What is wrong with them, and what explains it.
        doubt: String,
        /// The cause.
        source: Box<IdentifyError>,
    },
    /// The diagnosis failed.
    #[error(transparent)]
    Diagnose(Box<DiagnoseError>),
    /// An effect cannot be added or removed, or a fit on the way failed.
    #[error(transparent)]
    Analysis(Box<AnalysisError>),
    /// No cycle could be planned.
    #[error(transparent)]
    Plan(Box<PlanError>),
    /// An axis that a method cannot judge.
    #[error("machine {machine} has no rotary axis \"{name}\"; allowed: {allowed}")]
    NoSuchAxis {
        /// As asked.
        name: String,
        /// Name of the machine.
        machine: String,
        /// Its rotary axes.
        allowed: String,
    },
    /// A cycle that its machine cannot run.
    #[error(transparent)]
    Visit(Box<VisitError>),
    /// A machine whose controller takes places of the tool.
    #[error(
        "machine {machine} has legs in parallel: its controller takes places of the tool, not strokes of legs; \
         program the places of the cycle's balls with the machine's own transformation"
    )]
    Legs {
        /// Name of the machine.
        machine: String,
    },
    /// A dialect without tool centre point control.
    #[error("{dialect} has no tool centre point control here: leave --tcp out")]
    NoToolPoint {
        /// Name of the dialect.
        dialect: &'static str,
    },
    /// A recording that cannot be written.
    #[error("cannot write {}", path.display())]
    NotRecorded {
        /// The file.
        path: PathBuf,
        /// The cause, which does not name the file again.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A program that was built without Parquet.
    #[error("this program was built without Parquet; build it with `--features full`, or export csv")]
    NoParquet,
    /// A table of ours that is none; a defect of the program.
    #[cfg(feature = "parquet")]
    #[error("an exported table cannot be read; this is a defect of the program")]
    Table(#[source] csv::Error),
    /// Rows that do not become a Parquet table.
    #[cfg(feature = "parquet")]
    #[error("the rows cannot be written as Parquet")]
    Parquet(#[source] parquet::errors::ParquetError),
    /// Steps or readings that calibrate no nest.
    #[error("the nest cannot be calibrated")]
    Nest(#[source] Box<trunnion_sync::nest::NestError>),
    /// A setting for forming points that nothing takes.
    #[error(
        "cannot form points with {option}; allowed: KEY=VALUE of the cycle, e.g. settle.window_s=0.3, or nest.probe_1=[1, 0, 0]"
    )]
    FormOption {
        /// As asked.
        option: String,
    },
    /// A recording whose points cannot be formed again.
    #[error("{} holds no samples with the cycle that they were taken in; its points are all there is", path.display())]
    NoSamples {
        /// The file.
        path: PathBuf,
    },
    /// A named method cannot be applied.
    #[error(transparent)]
    Method(Box<trunnion_methods::recipes::MethodError>),
    /// The deviation of a recording cannot be attributed to its axes.
    #[error(transparent)]
    Attribution(Box<trunnion_methods::attribution::AttributionError>),
    /// A volume that the machine does not have.
    #[error(transparent)]
    Volume(Box<trunnion_methods::volumetric::VolumeError>),
    /// A model of another machine than that of the runs to predict.
    #[error(
        "the model was fitted on machine {fitted}, run {run} was measured on machine {found}; predict runs of one machine"
    )]
    OtherMachine {
        /// Machine of the fit.
        fitted: String,
        /// The run.
        run: String,
        /// Its machine.
        found: String,
    },
    /// A model file of another machine, where its values would be taken for these runs or those of these runs kept in it.
    #[error(
        "the model file is of machine \"{model}\", run {run} was measured on machine \"{found}\": values of one machine say nothing of \
         another. Name a model file of {found}; if both names are of one machine, write `machine = \"{found}\"` into this file"
    )]
    ModelOfOtherMachine {
        /// Machine of the model file.
        model: String,
        /// The run.
        run: String,
        /// Its machine.
        found: String,
    },
    /// Runs to predict without what a value of the model acts on.
    #[error("{run} cannot be predicted: {lacks} Record that too, or fit a model without it")]
    Lacks {
        /// The runs.
        run: String,
        /// What is missing, with the values that act on it.
        lacks: String,
    },
    /// Runs to predict in which an effect of the model cannot be looked at.
    #[error(
        "{run} cannot be predicted: {effect} of the model is out of reach of it. It {why}. Predict a run that has that, or fit a \
         model without {effect}"
    )]
    NoShare {
        /// The runs.
        run: String,
        /// Id of the effect.
        effect: String,
        /// What the runs lack, e.g. `needs time stamps`.
        why: String,
    },
    /// A model file without values to predict with.
    #[error(
        "the model file keeps no values of its effects: {why}; keep them with \
         `trunnion identify RUN --model FILE --keep`, or fit the model to runs of --fitted"
    )]
    NoValues {
        /// What happened to them.
        why: String,
    },
    /// No recording for a history.
    #[error("there is no recording of machine \"{machine}\" among these files; {allowed}")]
    NoRuns {
        /// As asked; empty when any would do.
        machine: String,
        /// What they hold.
        allowed: String,
    },
    /// A run that a history does not hold.
    #[error("there is no run \"{name}\" in this history; it holds {runs}")]
    NoSuchRun {
        /// As asked.
        name: String,
        /// Those there are.
        runs: String,
    },
    /// The effect is in the model file already.
    #[error(
        "{effect} is in the model already; remove it first, or delete its [effect.ladder] to measure it again"
    )]
    InModel {
        /// Effect id.
        effect: String,
    },
}

/// Large causes are boxed, so that an answer does not carry their size.
macro_rules! boxed {
    ($($variant:ident: $cause:ty),* $(,)?) => {
        $(impl From<$cause> for Error {
            fn from(cause: $cause) -> Self {
                Self::$variant(Box::new(cause))
            }
        })*
    };
}

boxed! {
    Experiment: ExperimentError,
    Fit: IdentifyError,
    Diagnose: DiagnoseError,
    Analysis: AnalysisError,
    Plan: PlanError,
    Visit: VisitError,
    Method: trunnion_methods::recipes::MethodError,
    Attribution: trunnion_methods::attribution::AttributionError,
    Volume: trunnion_methods::volumetric::VolumeError,
}

impl Error {
    /// Reading `path` failed.
    pub(crate) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Read { source: with_nearest(&path, source), path }
    }

    /// Writing `path` failed.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }

    /// Reading the recording `path` failed.
    pub(crate) fn recording(path: &Path) -> impl Fn(RecordError) -> Self + Copy + '_ {
        |source| Self::Recording { path: path.into(), source: source.without_file() }
    }

    /// Writing the recording `path` failed.
    pub(crate) fn not_recorded(path: &Path) -> impl Fn(RecordError) -> Self + Copy + '_ {
        |source| Self::NotRecorded { path: path.into(), source: source.without_file() }
    }
}
