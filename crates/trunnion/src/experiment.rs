//! Runs opened together, ready to be fitted.

mod read;

use crate::kept::Kept;
use crate::recording::Recording;
use crate::{Error, Model, completeness, identity, timing};
use read::{OfFile, Runs};
pub use read::{read, read_points};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use trunnion_core::Point;
use trunnion_cycles::Run;
use trunnion_effects as effects;
use trunnion_engine::plausibility::{Asked, Implausible, asked, not_asked, unlike};
use trunnion_engine::{ExperimentError, Identification, KnownFits, doubts_of_readings};
use trunnion_machine::{Machine, NamePlate};
use trunnion_results as results;
use trunnion_sync::blocks::Limits;

/// Runs of one machine, opened together. Clones share the data.
#[derive(Clone)]
pub struct Experiment {
    opened: Arc<Opened>,
}

struct Opened {
    runs: Vec<Run>,
    plate: NamePlate,
    points: trunnion_engine::Experiment,
    files: Vec<OfFile>,
    /// What only the points as they were read show.
    read: Vec<Implausible>,
    asked: OnceLock<Asked>,
    unlike: OnceLock<Vec<results::Doubt>>,
    of_readings: OnceLock<Vec<results::Doubt>>,
    complete: results::Complete,
    not_whole: Option<results::Plausibility>,
    doubts: Vec<results::Doubt>,
    /// Digest of the points.
    digest: OnceLock<String>,
}

/// Opens one run: a recording (`.mcap`), or a points file (`.csv`) with its `setup.toml` next to it.
///
/// # Errors
/// A file that cannot be read, or holds no usable point.
pub fn open(path: impl AsRef<Path>) -> Result<Experiment, Error> {
    open_all([path])
}

/// Opens several runs of one machine to be fitted together.
///
/// # Errors
/// As [`open`]; runs of different machines.
pub fn open_all<P: AsRef<Path>>(paths: impl IntoIterator<Item = P>) -> Result<Experiment, Error> {
    open_with(paths, Limits::default())
}

/// The same with other limits on the blocks to which a long run on the fly is reduced.
///
/// # Errors
/// As [`open_all`].
pub fn open_with<P: AsRef<Path>>(
    paths: impl IntoIterator<Item = P>,
    limits: Limits,
) -> Result<Experiment, Error> {
    let runs: Vec<Vec<PathBuf>> = paths.into_iter().map(|path| vec![path.as_ref().to_owned()]).collect();
    open_limited(&runs, limits)
}

/// Opens runs of one machine to be fitted together, each with the files that hold it: a recorder goes on in another file when its disk was
/// full. Points lost in between count as missing at the end of the cycle.
///
/// # Errors
/// As [`open_all`].
pub fn open_runs(runs: &[Vec<PathBuf>]) -> Result<Experiment, Error> {
    open_limited(runs, Limits::default())
}

fn open_limited(runs: &[Vec<PathBuf>], limits: Limits) -> Result<Experiment, Error> {
    let mut read = Runs::default();
    for files in runs {
        read.take(read::read_parts(files, limits)?);
    }
    Experiment::of_runs(read)
}

/// Runs without a usable point, with what is missing from their files first: it may be why.
fn nothing_left(none: ExperimentError, files: &[OfFile]) -> Error {
    let missing = files.iter().map(OfFile::missing);
    let losses: Vec<String> =
        missing.flat_map(|missing| missing.damage.into_iter().chain(missing.gaps)).collect();
    match none {
        ExperimentError::NoPoints { runs } if !losses.is_empty() => {
            Error::NothingLeft { runs, losses: losses.join("; ") }
        }
        other => other.into(),
    }
}

impl KnownFits for Experiment {
    fn fit(&self, model: &effects::Model) -> Option<Identification> {
        self.kept().fit(model)
    }

    fn made(&self, model: &effects::Model, fit: &Identification) {
        self.kept().made(model, fit);
    }
}

impl fmt::Debug for Experiment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Experiment").field(&self.points().runs).finish()
    }
}

impl Experiment {
    /// Recordings as read, each with its path.
    ///
    /// # Errors
    /// No usable point, or runs of different machines.
    pub fn of_recordings(recordings: Vec<(PathBuf, Recording)>) -> Result<Self, Error> {
        let mut read = Runs::default();
        recordings.into_iter().for_each(|recording| read.take(vec![recording]));
        Self::of_runs(read)
    }

    fn of_runs(read: Runs) -> Result<Self, Error> {
        let Runs { runs, readings, planned, samples, excluded, doubts, implausible: read, files, plate } =
            read;
        let (mut complete, not_whole) = completeness::complete(&runs, &planned);
        complete.samples = samples;
        complete.excluded.extend(excluded);
        let points = trunnion_engine::Experiment::new(&runs)
            .map_err(|none| nothing_left(none, &files))?
            .of_means(&readings);
        let opened = Opened {
            runs,
            plate,
            points,
            files,
            read,
            asked: OnceLock::new(),
            unlike: OnceLock::new(),
            of_readings: OnceLock::new(),
            complete,
            not_whole,
            doubts,
            digest: OnceLock::new(),
        };
        Ok(Self { opened: Arc::new(opened) })
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        self.opened.points.machine()
    }

    /// What the machine file says of the one machine: the first run that says it.
    pub fn plate(&self) -> &NamePlate {
        &self.opened.plate
    }

    /// The runs, as read.
    pub fn runs(&self) -> &[Run] {
        &self.opened.runs
    }

    /// Points, rows and columns of the runs together.
    pub fn points(&self) -> &trunnion_engine::Experiment {
        &self.opened.points
    }

    /// What was worked out of these points.
    pub(crate) fn kept(&self) -> Kept<'_> {
        Kept { points: self.points(), digest: &self.opened.digest }
    }

    /// True for the same readings at the same positions, also where they were opened twice.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let (own, others) = (&self.points().points, &other.points().points);
        let same = |(own, other): (&Point, &Point)| {
            own.reading_mm == other.reading_mm && own.state.position == other.state.position
        };
        Arc::ptr_eq(&self.opened, &other.opened)
            || own.len() == others.len() && own.iter().zip(others).all(same)
    }

    /// Why the runs cannot be judged: what no machine can do, the gravest first, and a part of the cycle that is missing; empty
    /// for good runs.
    pub fn plausibility(&self) -> Vec<results::Plausibility> {
        let found = self.asked().implausible.iter().chain(&self.opened.read);
        found.map(results::Plausibility::from).chain(self.opened.not_whole.clone()).collect()
    }

    fn asked(&self) -> &Asked {
        self.opened.asked.get_or_init(|| asked(&self.opened.runs))
    }

    /// What is planned, read, missing and excluded.
    pub fn complete(&self) -> results::Complete {
        results::Complete { losses: self.losses(), ..self.opened.complete.clone() }
    }

    /// What to doubt in the readings whatever is fitted to them.
    pub(crate) fn doubts(&self) -> Vec<results::Doubt> {
        let of_runs = || match self.plausibility().is_empty() {
            true => unlike(&self.opened.runs).iter().map(results::Doubt::unlike_runs).collect(),
            false => Vec::new(),
        };
        let of_runs = self.opened.unlike.get_or_init(of_runs);
        let of_readings = || doubts_of_readings(self.points()).iter().map(results::Doubt::from).collect();
        let of_readings = self.opened.of_readings.get_or_init(of_readings);
        let rounded: Vec<_> = self.asked().rounded.iter().map(results::Doubt::rounded).collect();
        self.opened.doubts.iter().chain(&rounded).chain(of_runs).chain(of_readings).cloned().collect()
    }

    /// Can these runs be what they say they are: `trunnion-check/1`.
    pub fn check(&self) -> results::Check {
        results::Check {
            runs: self.points().runs.clone(),
            points: self.points().points.len(),
            complete: self.complete(),
            plausibility: self.plausibility(),
            not_asked: not_asked(&self.opened.runs).into_iter().map(String::from).collect(),
            doubts: self.doubts(),
            ..results::Check::default()
        }
    }

    /// What is wrong with the files, one sentence for each that is damaged.
    pub fn damage(&self) -> Vec<String> {
        self.opened.files.iter().filter_map(|file| file.missing().damage).collect()
    }

    /// Gaps in what was asked of the devices, one sentence each with its file.
    pub fn gaps(&self) -> Vec<String> {
        self.opened.files.iter().flat_map(|file| file.missing().gaps).collect()
    }

    /// What is missing from the recordings, one sentence each: gaps in what was asked of the devices, damage.
    pub fn losses(&self) -> Vec<String> {
        let is_one = self.runs().len() == 1;
        self.opened.files.iter().flat_map(|file| file.losses(is_one)).collect()
    }

    /// How long runs on the fly were reduced to blocks, one sentence for each.
    pub fn reductions(&self) -> Vec<String> {
        self.opened.files.iter().filter_map(OfFile::reduction).collect()
    }

    /// How well each run with time stamps is known in time; the last one with what the sweeps show of delays, or why they show
    /// nothing: a delay is a side note.
    pub fn time_quality(&self) -> Vec<results::TimeQuality> {
        let timings = self.opened.files.iter().filter_map(|file| file.timing.as_ref());
        let mut timing: Vec<_> = timings.map(results::TimeQuality::from).collect();
        if let Some(last) = timing.last_mut() {
            let failed = |error| format!("Delays between the axes were not looked for: {error}.");
            last.notes
                .extend(timing::delay_by_feeds(self.points()).unwrap_or_else(|error| Some(failed(error))));
        }
        timing
    }

    /// Mean of all temperature channels, °C; `None` where none was recorded.
    pub fn temperature_degc(&self) -> Option<f64> {
        let ranges = self.runs().iter().flat_map(identity::temperatures);
        let means: Vec<f64> = ranges.map(|range| range.mean_degc).collect();
        (!means.is_empty()).then(|| means.iter().sum::<f64>() / means.len() as f64)
    }

    /// The model that every other begins with: location errors and ball setting.
    pub fn base_model(&self) -> Model {
        Model::base(&self.machine().name)
    }
}
