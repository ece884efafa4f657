//! Recordings of runs that are already in memory.

use crate::error::RecordError;
use crate::finish::FinishedFile;
use crate::item::{Item, RunHeader};
use crate::writer::Recorder;
use std::path::Path;
use trunnion_core::AxisSample;
use trunnion_cycles::Run;

/// Records a run that is already in memory as `path` (ending in `.mcap`).
///
/// # Errors
/// As [`Recorder::create`] and [`Recorder::finish`]; also when writing fails in between.
pub fn write_run(path: &Path, header: &RunHeader, run: &Run) -> Result<FinishedFile, RecordError> {
    write_run_with_axes(path, header, run, &[])
}

/// The same with the positions of the axes, in order of time.
///
/// # Errors
/// As [`write_run`].
pub fn write_run_with_axes(
    path: &Path,
    header: &RunHeader,
    run: &Run,
    axes: &[AxisSample],
) -> Result<FinishedFile, RecordError> {
    let dir = match path.parent() {
        Some(dir) if !dir.as_os_str().is_empty() => dir,
        _ => Path::new("."),
    };
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut recorder = Recorder::create(dir, &name, header)?;
    for point in &run.points {
        recorder.append(Item::Point(point.clone()), header.host_start);
    }
    for sample in axes {
        recorder.append(Item::Axes(*sample), header.host_start);
    }
    if let Some(why) = recorder.failing() {
        let source = std::io::Error::other(why.to_string());
        return Err(RecordError::Io { what: "write", path: path.into(), source });
    }
    let finished = recorder.finish(header.host_start)?;
    let first = finished.files.into_iter().next();
    first.ok_or_else(|| RecordError::Exists { path: path.into() })
}
