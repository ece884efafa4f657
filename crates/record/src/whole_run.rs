//! Recordings of runs that are already in memory.

use crate::error::RecordError;
use crate::finish::FinishedFile;
use crate::item::{Item, RunHeader};
use crate::journal_file::remove_unready;
use crate::writer::Recorder;
use std::path::{Path, PathBuf};
use std::time::Duration;
use trunnion_core::{AxisSample, HostTime, Point};
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
    let mut writer = RunWriter::create(path, header)?;
    run.points.iter().for_each(|point| writer.point(point.clone()));
    axes.iter().for_each(|sample| writer.axes(*sample));
    writer.finish()
}

/// Records points one by one, as they are imported.
pub struct RunWriter {
    recorder: Recorder,
    path: PathBuf,
    host_start: HostTime,
}

impl RunWriter {
    /// Begins the recording `path` (ending in `.mcap`).
    ///
    /// # Errors
    /// As [`Recorder::create`]; another ending.
    pub fn create(path: &Path, header: &RunHeader) -> Result<Self, RecordError> {
        if path.extension().is_none_or(|ending| ending != "mcap") {
            return Err(RecordError::Ending { path: path.into(), better: path.with_extension("mcap") });
        }
        let dir = match path.parent() {
            Some(dir) if !dir.as_os_str().is_empty() => dir,
            _ => Path::new("."),
        };
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let recorder = Recorder::create(dir, &name, header)?;
        Ok(Self { recorder, path: path.into(), host_start: header.host_start })
    }

    /// Takes the next point.
    pub fn point(&mut self, point: Point) {
        self.item(Item::Point(point), 0.0);
    }

    /// Takes the next positions of the axes.
    pub fn axes(&mut self, sample: AxisSample) {
        self.item(Item::Axes(sample), 0.0);
    }

    /// Takes whatever comes next, as if it had come so long after the beginning of the run, s: batches are as long as live.
    pub fn item(&mut self, item: Item, at_s: f64) {
        self.recorder.append(item, self.host_start + Duration::from_secs_f64(at_s.max(0.0)));
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// As [`Recorder::finish`]; also when writing failed in between. What a disk refused is thrown away: its source is still there.
    pub fn finish(self) -> Result<FinishedFile, RecordError> {
        let Self { mut recorder, path, host_start } = self;
        let journals: Vec<PathBuf> = recorder.journals().map(Path::to_path_buf).collect();
        let finished = match recorder.take_failure() {
            Some(failure) => {
                drop(recorder);
                Err(failure)
            }
            None => recorder.finish(host_start),
        };
        if finished.as_ref().is_err_and(RecordError::may_pass) {
            journals.iter().for_each(|journal| remove_unready(journal));
        }
        finished?.files.into_iter().next().ok_or(RecordError::Exists { path })
    }

    /// Throws away what was written.
    ///
    /// # Errors
    /// When the journal cannot be removed.
    pub fn discard(self) -> Result<(), RecordError> {
        let journals: Vec<PathBuf> = self.recorder.journals().map(Path::to_path_buf).collect();
        drop(self.recorder);
        journals
            .iter()
            .try_for_each(|path| std::fs::remove_file(path).map_err(RecordError::io("remove", path)))
    }
}
