//! Runs opened together, ready to be fitted.

use crate::recording::{self, Recording};
use crate::{Error, Model, completeness, files, identity, page, timing};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use trunnion_cycles::Run;
use trunnion_engine::plausibility::{Implausible, implausible};
use trunnion_machine::{Machine, NamePlate};
use trunnion_results as results;
use trunnion_sync::blocks::Limits;
use trunnion_sync::time_quality::TimeQuality;

/// Runs of one machine, opened together. Clones share the data.
#[derive(Clone)]
pub struct Experiment {
    opened: Arc<Opened>,
}

struct Opened {
    runs: Vec<Run>,
    plate: NamePlate,
    points: trunnion_engine::Experiment,
    timing: Vec<TimeQuality>,
    damage: Vec<String>,
    gaps: Vec<String>,
    losses: Vec<String>,
    reductions: Vec<String>,
    implausible: OnceLock<Vec<Implausible>>,
    complete: results::Complete,
    not_whole: Option<results::Plausibility>,
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
    let recordings: Vec<(PathBuf, Recording)> = paths
        .into_iter()
        .map(|path| Ok((path.as_ref().to_owned(), read(path.as_ref(), Some(limits))?)))
        .collect::<Result<_, Error>>()?;
    Experiment::of_recordings(recordings)
}

/// Opens runs of one machine to be fitted together, each with the recordings that hold it. The parts of a run have its name, its zero of
/// time and its setups, so that their points are those of one run.
///
/// # Errors
/// As [`open_all`].
pub(crate) fn open_runs(runs: &[Vec<PathBuf>]) -> Result<Experiment, Error> {
    let mut recordings = Vec::new();
    for parts in runs {
        let mut read = parts.iter().map(|path| Ok::<_, Error>((path, read(path, Some(Limits::default()))?)));
        let Some(first) = read.next() else { continue };
        let (path, mut whole) = first?;
        for part in read {
            whole.run.points.extend(part?.1.run.points);
        }
        recordings.push((path.clone(), whole));
    }
    Experiment::of_recordings(recordings)
}

/// Reads a recording, or a points file with its `setup.toml`; with `limits` a long run on the fly is reduced to blocks.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path, limits: Option<Limits>) -> Result<Recording, Error> {
    if path.extension().is_some_and(|ending| ending == "csv") {
        let run = read_points(path, &path.with_file_name("setup.toml"))?;
        return Ok(Recording {
            run,
            reduction: None,
            planned: None,
            gaps: Vec::new(),
            damage: None,
            timing: None,
            samples: None,
            plate: NamePlate::default(),
        });
    }
    recording::read(path, &|name| files::machine(name).ok(), limits)
        .map_err(|source| Error::Recording { path: path.into(), source: Box::new(source) })
}

/// Reads a points file with its setup file.
///
/// # Errors
/// Every problem of both files at once.
pub fn read_points(points: &Path, setup: &Path) -> Result<Run, Error> {
    let stem = points.file_stem().map_or_else(|| "points".into(), |stem| stem.to_string_lossy());
    // `points.csv` is called after its folder.
    let folder = points.parent().and_then(Path::file_name).map(|name| name.to_string_lossy());
    let name = folder.filter(|_| stem == "points").unwrap_or(stem);
    let (setup_text, points_text) = (files::read(setup)?, files::read(points)?);
    Ok(trunnion_record::points_csv::import_files(
        &name,
        (&points.display().to_string(), &points_text),
        (&setup.display().to_string(), &setup_text),
        &|machine| files::machine(machine).ok(),
    )?)
}

impl Experiment {
    /// Recordings as read, each with its path.
    ///
    /// # Errors
    /// No usable point, or runs of different machines.
    pub fn of_recordings(recordings: Vec<(PathBuf, Recording)>) -> Result<Self, Error> {
        let (mut runs, mut timing, mut damage, mut reductions) = (vec![], vec![], vec![], vec![]);
        let (mut planned, mut samples, mut plate) = (Vec::new(), Vec::new(), NamePlate::default());
        let (mut gaps, mut losses, is_one) = (Vec::new(), Vec::new(), recordings.len() == 1);
        for (path, recording) in recordings {
            let named = |text: String| format!("{}: {text}", path.display());
            damage.extend(recording.damage.as_ref().map(|damage| named(damage.to_string())));
            let name = &recording.run.name;
            let of_run = |text: String| if is_one { text } else { format!("{name}: {text}") };
            let of_recording = page::losses(&recording.gaps, 0);
            gaps.extend(of_recording.iter().map(|gap| named(gap.clone())));
            losses.extend(of_recording.into_iter().map(of_run));
            losses.extend(recording.damage.map(|damage| of_run(format!("the file is {damage}"))));
            reductions.extend(recording.reduction.map(named));
            timing.extend(recording.timing);
            samples.extend(
                recording.samples.and_then(|counts| results::Samples::of(&recording.run.name, &counts)),
            );
            plate = plate.or(recording.plate);
            runs.push(recording.run);
            planned.push(recording.planned);
        }
        let (complete, not_whole) = completeness::complete(&runs, &planned);
        let complete = results::Complete { samples, ..complete };
        let points = trunnion_engine::Experiment::new(&runs)?;
        Ok(Self {
            opened: Arc::new(Opened {
                runs,
                plate,
                points,
                timing,
                damage,
                gaps,
                losses,
                reductions,
                implausible: OnceLock::new(),
                complete,
                not_whole,
            }),
        })
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

    /// Why the runs cannot be judged: what no machine can do, the gravest first, and a part of the cycle that is missing; empty
    /// for good runs.
    pub fn plausibility(&self) -> Vec<results::Plausibility> {
        let found = self.opened.implausible.get_or_init(|| implausible(&self.opened.runs));
        found.iter().map(results::Plausibility::from).chain(self.opened.not_whole.clone()).collect()
    }

    /// What is planned, read, missing and excluded.
    pub fn complete(&self) -> results::Complete {
        self.opened.complete.clone()
    }

    /// Can these runs be what they say they are: `trunnion-check/1`.
    pub fn check(&self) -> results::Check {
        results::Check {
            runs: self.points().runs.clone(),
            points: self.points().points.len(),
            complete: self.complete(),
            plausibility: self.plausibility(),
            ..results::Check::default()
        }
    }

    /// What is wrong with the files, one sentence for each that is damaged.
    pub fn damage(&self) -> &[String] {
        &self.opened.damage
    }

    /// Gaps in what was asked of the devices, one sentence each with its file.
    pub fn gaps(&self) -> &[String] {
        &self.opened.gaps
    }

    /// What is missing from the recordings, one sentence each: gaps in what was asked of the devices, damage.
    pub fn losses(&self) -> &[String] {
        &self.opened.losses
    }

    /// How long runs on the fly were reduced to blocks, one sentence for each.
    pub fn reductions(&self) -> &[String] {
        &self.opened.reductions
    }

    /// How well each run with time stamps is known in time; the last one with what the sweeps show of delays, or why they show
    /// nothing: a delay is a side note.
    pub fn time_quality(&self) -> Vec<results::TimeQuality> {
        let mut timing: Vec<_> = self.opened.timing.iter().map(results::TimeQuality::from).collect();
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
