//! Tables in and out: points measured elsewhere become a recording, a recording becomes a table.

#[cfg_attr(not(feature = "parquet"), path = "tables/without_parquet.rs")]
pub mod parquet;

mod by_effect;

pub use by_effect::by_effect_csv;

use crate::experiment::read;
use crate::gaps::Missing;
use crate::{Error, Experiment, files};
use std::path::Path;
use trunnion_core::setup::{SetupFile, parse_setup_file};
use trunnion_core::{AxisSample, Point};
use trunnion_cycles::{Run, RunKind};
use trunnion_record::{Item, RunHeader, RunWriter, points_csv};
use trunnion_results as results;

/// Reads a points file with its setup file and writes the recording `output`, which gives the run its name; gives the run
/// without its points, and their number. The recording is begun with the first row, and thrown away when a later one is wrong.
///
/// # Errors
/// Every problem of both files at once; a recording that cannot be written.
pub fn import(kind: RunKind, points: &Path, setup: &Path, output: &Path) -> Result<(Run, u64), Error> {
    let (setup_text, points_text) = (files::read(setup)?, files::read_table(points)?);
    let (points_file, setup_file) = (points.display().to_string(), setup.display().to_string());
    let name = output.file_stem().map_or_else(|| "run".into(), |stem| stem.to_string_lossy());
    let not_written = Error::not_recorded(output);
    let begin = |run: &Run| -> Result<RunWriter, Error> {
        let SetupFile { machine, calibrations, .. } = parse_setup_file(&setup_file, &setup_text)?;
        let machine_text = files::machine_text(&files::next_to(setup, &machine))?;
        let of_run = RunHeader::of_run(run, &machine_text, env!("CARGO_PKG_VERSION"), 0);
        let header = RunHeader { calibrations, ..of_run };
        RunWriter::create(output, &header).map_err(not_written)
    };
    let (mut writer, mut count) = (None, 0_u64);
    let mut on_row = |run: &Run, point: Point, actual: Option<AxisSample>| {
        if let Ok(writer) = writer.get_or_insert_with(|| begin(run)) {
            writer.point(point);
            actual.into_iter().for_each(|actual| writer.axes(actual));
        }
        count += 1;
    };
    let read = files::with_machines(setup, |machine| {
        let (points, setup) = ((&*points_file, &*points_text), (&*setup_file, &*setup_text));
        points_csv::visit_files(kind, &name, points, setup, machine, &mut on_row)
    });
    match (read, writer) {
        (Ok(run), Some(writer)) => writer?.finish().map(|_| (run, count)).map_err(not_written),
        (Ok(run), None) => Ok((run, count)),
        (Err(error), writer) => {
            if let Some(Ok(writer)) = writer {
                writer.discard().map_err(not_written)?;
            }
            Err(error)
        }
    }
}

/// Leaves passwords out of a recording that an older version made; see [`trunnion_record::scrub`].
///
/// # Errors
/// A file that is no finished recording, or a copy that cannot be written; the recording is then as it was.
pub fn scrub(path: &Path) -> Result<results::ScrubbedRecording, Error> {
    let scrubbed = trunnion_record::scrub(path).map_err(Error::recording(path))?;
    let damage = scrubbed.damage.map(|damage| damage.to_string());
    Ok(results::ScrubbedRecording { run: path.display().to_string(), changed: scrubbed.changed, damage })
}

/// The points of a recording as a table, on the fly with what the encoders read; and what is missing from it.
///
/// # Errors
/// A file that cannot be read.
pub fn export_csv(path: &Path) -> Result<(String, Missing), Error> {
    let recording = read(path, None)?;
    let mut axes = Vec::new();
    if recording.run.kind == RunKind::OnTheFly {
        trunnion_record::visit(path, &mut |item| {
            if let Item::Axes(sample) = item {
                axes.push(sample);
            }
            true
        })
        .map_err(Error::recording(path))?;
    }
    let missing = Missing::of(path, &recording.gaps, recording.damage.as_ref());
    Ok((trunnion_record::export::points_csv_with_axes(&recording.run, &axes), missing))
}

impl Experiment {
    /// The good points of each run as a table, with its name: long runs on the fly as the blocks that are fitted.
    pub fn points_csv(&self) -> Vec<(String, String)> {
        let table = |run: &Run| (run.name.clone(), trunnion_record::export::points_csv(run));
        self.runs().iter().map(table).collect()
    }
}

/// What of a recording is exported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exported {
    /// Good points, as they are imported.
    Points,
    /// Points of every quality.
    EveryPoint,
    /// Samples of the probes as the devices sent them.
    Samples,
    /// Positions of the axes.
    Axes,
}

impl Exported {
    /// Every kind with its name.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("points", Self::Points),
        ("every-point", Self::EveryPoint),
        ("samples", Self::Samples),
        ("axes", Self::Axes),
    ];
}

/// A part of a recording as a table; and what is missing from it.
///
/// # Errors
/// A file that cannot be read.
pub fn export(path: &Path, what: Exported) -> Result<(String, Missing), Error> {
    match what {
        Exported::Points => export_csv(path),
        Exported::EveryPoint => {
            let recording = read(path, None)?;
            let table = trunnion_record::export::every_point_csv(&recording.run);
            Ok((table, Missing::of(path, &recording.gaps, recording.damage.as_ref())))
        }
        Exported::Samples | Exported::Axes => {
            let (mut probes, mut axes) = (Vec::new(), Vec::new());
            let (header, damage) = trunnion_record::visit_samples(path, &mut |item| {
                match item {
                    Item::Probe(sample) if what == Exported::Samples => probes.push(sample),
                    Item::Axes(sample) if what == Exported::Axes => axes.push(sample),
                    _ => {}
                }
                true
            })
            .map_err(Error::recording(path))?;
            let table = match what {
                Exported::Samples => trunnion_record::export::probe_samples_csv(&header, &probes),
                _ => {
                    let named = || files::machine(&header.machine_name);
                    let machine = header.machine().and_then(Result::ok).map_or_else(named, Ok)?;
                    trunnion_record::export::axis_samples_csv(&machine.joints(), &axes)
                }
            };
            Ok((table, Missing::of_samples(path, damage.as_ref())?))
        }
    }
}

/// Writes a run whole as a recording, with the texts of its machine and cycle and the positions of its axes, where they are
/// known.
///
/// # Errors
/// A recording that cannot be written.
pub fn record(
    path: &Path,
    run: &Run,
    machine_text: &str,
    cycle_text: &str,
    axes: &[AxisSample],
) -> Result<(), Error> {
    let mut header = RunHeader::of_run(run, machine_text, env!("CARGO_PKG_VERSION"), 0);
    header.cycle_text = cycle_text.into();
    trunnion_record::write_run_with_axes(path, &header, run, axes)
        .map(drop)
        .map_err(Error::not_recorded(path))
}
