//! From files to runs: each file is read, and those of one run are put together.

use crate::gaps::Missing;
use crate::recording::{self, Recording};
use crate::reduced::Reduced;
use crate::{Error, completeness, files, page};
use std::path::{Path, PathBuf};
use trunnion_core::Gap;
use trunnion_cycles::Run;
use trunnion_engine::plausibility::{Implausible, PositionDigits, Rounded, clock_doubt};
use trunnion_machine::NamePlate;
use trunnion_record::{Damage, points_csv};
use trunnion_results as results;
use trunnion_sync::SampleCounts;
use trunnion_sync::blocks::Limits;
use trunnion_sync::time_quality::TimeQuality;

/// Reads a recording, or a points file with its `setup.toml`; with `limits` a long run on the fly is reduced to blocks.
///
/// # Errors
/// A file that cannot be read.
pub fn read(path: &Path, limits: Option<Limits>) -> Result<Recording, Error> {
    read_next(path, limits, None)
}

/// Reads the files of one run, in order of time. Further files have its name, its zero of time and its setups, and go on with its cycle.
///
/// # Errors
/// As [`read`].
pub(super) fn read_parts(paths: &[PathBuf], limits: Limits) -> Result<Vec<(PathBuf, Recording)>, Error> {
    let mut parts: Vec<(PathBuf, Recording)> = Vec::new();
    for path in paths {
        let planned = parts.last_mut().and_then(|(_, before)| before.planned.take());
        parts.push((path.clone(), read_next(path, Some(limits), planned)?));
    }
    Ok(parts)
}

/// Reads a file that goes on with the cycle of the one before.
fn read_next(
    path: &Path,
    limits: Option<Limits>,
    planned: Option<completeness::Planned>,
) -> Result<Recording, Error> {
    if path.extension().is_some_and(|ending| ending == "csv") {
        let run = read_points(path, &path.with_file_name("setup.toml"))?;
        let mut digits = PositionDigits::new(&run.machine, &run.setups, run.kind);
        run.points.iter().for_each(|point| digits.take(point));
        return Ok(Recording {
            rounded: digits.finish(&run.name),
            run,
            reduction: None,
            planned,
            gaps: Vec::new(),
            damage: None,
            timing: None,
            samples: None,
            plate: NamePlate::default(),
            calibration: Vec::new(),
        });
    }
    recording::read_next(path, &|name| files::machine(name).ok(), limits, planned)
        .map_err(Error::recording(path))
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
    let (setup_text, points_text) = (files::read(setup)?, files::read_table(points)?);
    let (points_file, setup_file) = (points.display().to_string(), setup.display().to_string());
    files::with_machines(setup, |machine| {
        points_csv::import_files(&name, (&points_file, &points_text), (&setup_file, &setup_text), machine)
    })
}

/// What is known of one file apart from its points.
pub(super) struct OfFile {
    path: PathBuf,
    /// Name of its run.
    run: String,
    reduction: Option<String>,
    gaps: Vec<Gap>,
    damage: Option<Damage>,
    pub(super) timing: Option<TimeQuality>,
}

impl OfFile {
    /// How points became fewer.
    pub(super) fn reduction(&self) -> Option<String> {
        self.reduction.as_ref().map(|text| format!("{}: {text}", self.path.display()))
    }

    /// Gaps in what was asked of the devices, and damage, with the file.
    pub(super) fn missing(&self) -> Missing {
        Missing::of(&self.path, &self.gaps, self.damage.as_ref())
    }

    /// What is missing, gaps and damage; with the run where there are several.
    pub(super) fn losses(&self, is_one: bool) -> Vec<String> {
        let damage = self.damage.as_ref().map(|damage| format!("the file is {damage}"));
        let all = page::losses(&self.gaps, 0).into_iter().chain(damage);
        all.map(|text| if is_one { text } else { format!("{}: {text}", self.run) }).collect()
    }
}

/// Runs, each put together from its files.
#[derive(Default)]
pub(super) struct Runs {
    pub(super) runs: Vec<Run>,
    /// Readings behind a point of each run at rest, the mean: 1 where every point is as read.
    pub(super) readings: Vec<f64>,
    pub(super) planned: Vec<Option<completeness::Planned>>,
    pub(super) samples: Vec<results::Samples>,
    pub(super) excluded: Vec<results::Excluded>,
    pub(super) doubts: Vec<results::Doubt>,
    /// What only the points as they were read show: no mean of them has their digits.
    pub(super) implausible: Vec<Implausible>,
    pub(super) files: Vec<OfFile>,
    pub(super) plate: NamePlate,
}

impl Runs {
    /// The next run from its files.
    pub(super) fn take(&mut self, parts: Vec<(PathBuf, Recording)>) {
        let (mut whole, mut planned, mut samples) = (None::<Run>, None, None::<SampleCounts>);
        let mut reduced = None::<Reduced>;
        let (mut rounded, mut calibration) = (None::<Rounded>, Vec::<results::Doubt>::new());
        let (mut readings, mut points) = (0.0, 0.0);
        for (path, part) in parts {
            let Recording { mut run, reduction, gaps, damage, timing, .. } = part;
            rounded = rounded.or(part.rounded);
            // The parts are of one run and one set of sensors.
            if calibration.is_empty() {
                calibration = part.calibration;
            }
            let good = run.good_points().count() as f64;
            readings +=
                reduction.as_ref().and_then(Reduced::readings_at_rest).map_or(good, |count| count as f64);
            points += good;
            let summary = reduction.as_ref().map(|reduction| reduction.summary.clone());
            self.files.push(OfFile { path, run: run.name.clone(), reduction: summary, gaps, damage, timing });
            reduced = match (reduced, reduction) {
                (Some(before), Some(next)) => Some(before.and(next)),
                (before, next) => before.or(next),
            };
            self.plate = std::mem::take(&mut self.plate).or(part.plate);
            // The plan of the last part counts those before it.
            planned = part.planned.or(planned);
            samples = match (samples, part.samples) {
                (Some(before), Some(next)) => Some(before.and(&next)),
                (before, next) => before.or(next),
            };
            match &mut whole {
                Some(whole) => whole.points.append(&mut run.points),
                None => whole = Some(run),
            }
        }
        let Some(run) = whole else { return };
        let reduced = reduced.unwrap_or_default();
        self.samples.extend(samples.and_then(|counts| results::Samples::of(&run.name, &counts)));
        self.excluded.extend(reduced.excluded());
        self.doubts.extend(calibration);
        self.doubts.extend(reduced.doubt(&run));
        self.doubts.extend(clock_doubt(&run).map(|doubt| results::Doubt::clock(&run.name, &doubt)));
        let (gross, small): (Vec<Rounded>, Vec<Rounded>) = rounded.into_iter().partition(Rounded::is_gross);
        self.implausible.extend(gross.iter().map(Rounded::implausible));
        self.doubts.extend(small.iter().map(results::Doubt::rounded));
        self.runs.push(run);
        self.readings.push(if points > 0.0 { readings / points } else { 1.0 });
        self.planned.push(planned);
    }
}
