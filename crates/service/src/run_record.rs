//! The state of a run on disk: `NAME.state.json` next to its recording, written whole or not at all.

use crate::error::ServiceError;
use crate::recording::Recorded;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use tracing::warn;
use trunnion::gaps::gaps_of;
use trunnion::results::{RunAnswer, RunRecord, RunState, Verdict, to_json};
use trunnion_core::chain;

const ENDING: &str = "state.json";

/// Where the state of a recording is.
pub fn path_of(recording: &Path) -> PathBuf {
    recording.with_extension(ENDING)
}

/// The state of a recording; `None` where none was written, or none that can be read.
pub fn read(recording: &Path) -> Option<RunRecord> {
    let path = path_of(recording);
    let text = std::fs::read_to_string(&path).ok()?;
    serde_json::from_str(&text)
        .inspect_err(|error| warn!(%error, file = %path.display(), "this state of a run is not taken"))
        .ok()
}

/// Writes the state of a recording.
///
/// # Errors
/// When the file cannot be written.
pub fn write(recording: &Path, record: &RunRecord) -> Result<(), ServiceError> {
    Ok(trunnion::files::write_whole(&path_of(recording), &to_json(record)?)?)
}

/// The state of what was just recorded.
pub fn of_recorded(recorded: &Recorded, cycle: &str, at: String) -> RunRecord {
    RunRecord {
        state: RunState::Recorded,
        at,
        cycle: cycle.into(),
        parts: recorded.parts.iter().filter_map(|path| file_name(path)).collect(),
        losses: trunnion::page::losses(&recorded.gaps, recorded.lost_samples),
        ..RunRecord::default()
    }
}

/// The state of a recording that says all there is to know of it.
pub fn of_recording(recording: &Path, state: RunState, at: String) -> RunRecord {
    let (cycle, losses) = match gaps_of(recording) {
        Ok((cycle, gaps)) => (cycle, trunnion::page::losses(&gaps, 0)),
        // It is listed too: nobody may take it for one without gaps.
        Err(error) => (String::new(), vec![format!("what is missing is not known: {}", chain(&error))]),
    };
    RunRecord { state, at, cycle, losses, ..RunRecord::default() }
}

/// The state of a run with this report.
pub fn reported(record: RunRecord, answer: RunAnswer) -> RunRecord {
    let (state, why) = match answer.result.verdict {
        Verdict::NotJudged => (RunState::NotJudged, answer.result.why.clone()),
        _ => (RunState::Done, String::new()),
    };
    RunRecord { state, why, answer: Some(answer), ..record }
}

/// The files that hold a run, each sample once.
pub fn files(recording: &Path, record: &RunRecord) -> Vec<PathBuf> {
    let part = |name: &String| recording.with_file_name(name);
    std::iter::once(recording.to_owned()).chain(record.parts.iter().map(part)).collect()
}

/// The same by the record that is kept of it.
pub fn files_of(recording: &Path) -> Vec<PathBuf> {
    files(recording, &read(recording).unwrap_or_default())
}

/// The same with those that it was joined from.
pub fn every_file(recording: &Path, record: &RunRecord) -> Vec<PathBuf> {
    let mut every = files(recording, record);
    every.extend(record.joined_from.iter().map(|name| recording.with_file_name(name)));
    every
}

/// How the state of a run calls a file.
pub fn file_name(path: &Path) -> Option<String> {
    path.file_name().map(|name| name.to_string_lossy().into_owned())
}

/// Runs of a folder whose samples were removed: where the recording was, when and why.
pub fn removed_from(folder: &Path) -> Vec<(PathBuf, String)> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let state_of = |path: PathBuf| {
        let name = path.file_name()?.to_str()?.strip_suffix(ENDING)?.strip_suffix('.')?.to_owned();
        let recording = path.with_file_name(name + ".mcap");
        // One that is there again was put back.
        let why = (!recording.exists()).then(|| read(&recording)).flatten()?.removed?;
        Some((recording, why))
    };
    entries.filter_map(|entry| state_of(entry.path())).collect()
}

/// Every recording of a folder with its state, the newest first.
pub struct Known {
    /// The newest first.
    pub runs: Vec<(PathBuf, RunRecord)>,
}

impl Known {
    /// Reads the folder, recordings that are linked from elsewhere too, each once; a recording without a state has the report that
    /// stands next to it, or none. A further part of a run is no run of its own.
    pub fn read(folder: &Path) -> Self {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut aged: Vec<_> = entries
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|ending| ending == "mcap"))
            .filter(|path| path.is_file() && !leads_back(path, folder))
            .map(|path| (path.metadata().and_then(|about| about.modified()).ok(), path))
            .collect();
        aged.sort_by(|a, b| b.cmp(a));
        let mut places = HashSet::new();
        aged.retain(|(_, path)| path.canonicalize().map_or(true, |place| places.insert(place)));
        let state = |(_, path): (_, PathBuf)| {
            let record = read(&path).unwrap_or_else(|| {
                let has_report = path.with_extension("diagnosis.json").exists();
                let state = if has_report { RunState::Done } else { RunState::Recorded };
                RunRecord { state, ..RunRecord::default() }
            });
            (path, record)
        };
        let runs: Vec<(PathBuf, RunRecord)> = aged.into_iter().map(state).collect();
        let parts: HashSet<PathBuf> =
            runs.iter().flat_map(|(path, record)| every_file(path, record).into_iter().skip(1)).collect();
        Self { runs: runs.into_iter().filter(|(path, _)| !parts.contains(path)).collect() }
    }

    /// What was found last.
    pub fn newest_report(&self) -> Option<&RunRecord> {
        self.runs
            .iter()
            .map(|(_, record)| record)
            .filter(|record| record.answer.is_some())
            .max_by_key(|r| &r.at)
    }
}

/// True for a link to a file of the folder itself, which is there under its own name.
fn leads_back(path: &Path, folder: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok();
    path.is_symlink() && place(path).and_then(|file| Some(file.parent()? == place(folder)?)).unwrap_or(false)
}

/// True for a run that is still to be analysed. A part whose joined run is there is no run of [`Known`]: without that run it is one again.
pub fn is_pending(record: &RunRecord, tries: u32) -> bool {
    match record.state {
        RunState::Recorded | RunState::Recovered | RunState::Joined => true,
        RunState::Analysing | RunState::Failed => record.tries < tries,
        RunState::Done | RunState::NotJudged => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_recording_that_cannot_be_read_is_not_taken_for_one_without_gaps() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken.mcap");
        std::fs::write(&broken, b"no recording").unwrap();
        let record = of_recording(&broken, RunState::Recorded, "now".into());
        let [loss] = &record.losses[..] else { panic!("{record:?}") };
        assert!(loss.starts_with("what is missing is not known: ") && loss.contains("broken.mcap"), "{loss}");
    }

    #[test]
    fn a_recording_that_is_linked_from_elsewhere_is_a_run_and_a_second_name_is_none() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        std::fs::write(folder.path().join("monday.mcap"), b"").unwrap();
        std::fs::write(elsewhere.path().join("tuesday.mcap"), b"").unwrap();
        symlink(elsewhere.path().join("tuesday.mcap"), folder.path().join("tuesday.mcap")).unwrap();
        symlink(elsewhere.path().join("tuesday.mcap"), folder.path().join("again.mcap")).unwrap();
        symlink(folder.path().join("monday.mcap"), folder.path().join("latest.mcap")).unwrap();
        symlink(folder.path().join("gone.mcap"), folder.path().join("broken.mcap")).unwrap();
        std::fs::create_dir(folder.path().join("folder.mcap")).unwrap();
        let mut names: Vec<_> =
            Known::read(folder.path()).runs.iter().filter_map(|run| file_name(&run.0)).collect();
        names.sort();
        assert_eq!(names, ["monday.mcap", "tuesday.mcap"]);
    }
}
