//! What a list says of a recording: from its header, and from the answers that the service wrote next to it.

use crate::found::in_short;
use crate::kept_story::{self, Kept};
use crate::run_record::{self, Known};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use trunnion::cycles::Cycle;
use trunnion::results::{Diagnosis, Identification, RunFound, RunLine};
use trunnion_protocol::mtconnect::parse_timestamp;

/// Newest recordings of a folder that are listed.
const MOST_RUNS: usize = 1000;

/// Name and path of each run of a folder; the newest where there are too many. Further parts of a run are no runs of their own.
pub fn recordings(folder: &Path) -> Vec<(String, PathBuf)> {
    let newest_first = Known::read(folder).runs.into_iter().map(|(path, _)| path);
    let mut runs: Vec<PathBuf> = newest_first.take(MOST_RUNS).collect();
    runs.sort();
    runs.into_iter().map(|path| (name_of(&path), path)).collect()
}

/// How calls name a recording.
pub fn name_of(path: &Path) -> String {
    let text = |part: Option<&std::ffi::OsStr>| part.map(|text| text.to_string_lossy().into_owned());
    let stem = text(path.file_stem()).unwrap_or_default();
    // `points.csv` is called after its folder.
    let folder = text(path.parent().and_then(Path::file_name)).filter(|_| stem == "points");
    folder.unwrap_or(stem)
}

/// The line of a recording.
pub fn read(name: String, path: &Path) -> RunLine {
    if path.extension().is_none_or(|ending| ending != "mcap") {
        return RunLine { name, ..RunLine::default() };
    }
    match trunnion_record::read_header(path) {
        Ok(header) => {
            // Imports and simulations have no moment.
            let began_ns = Some(header.wall_start_ns).filter(|ns| *ns > 0);
            RunLine {
                name,
                machine: header.machine_name,
                began_s: began_ns.map(|ns| ns / 1_000_000_000),
                began: trunnion::moment::minute(header.wall_start_ns).unwrap_or_default(),
                ..RunLine::default()
            }
        }
        Err(failure) => RunLine { name, trouble: trunnion_core::chain(&failure), ..RunLine::default() },
    }
}

/// Name of the cycle of a recording; empty where it is not known.
pub fn cycle_of(recording: &Path) -> String {
    let known = run_record::read(recording).map(|record| record.cycle).filter(|cycle| !cycle.is_empty());
    let of_header = || {
        let header = trunnion_record::read_header(recording).ok()?;
        Some(Cycle::parse("recorded cycle", &header.cycle_text).ok()?.name)
    };
    known.or_else(of_header).unwrap_or_default()
}

/// Runs of a folder whose samples were removed: name, where the recording was, when and why.
pub fn removed_from(folder: &Path) -> Vec<(String, PathBuf, String)> {
    let named = |(path, why): (PathBuf, String)| (name_of(&path), path, why);
    let mut removed: Vec<_> = run_record::removed_from(folder).into_iter().map(named).collect();
    removed.sort();
    removed.drain(..removed.len().saturating_sub(MOST_RUNS));
    removed
}

/// The line of a run whose samples were removed, from the answers that stayed.
pub fn removed(name: String, path: &Path, why: String) -> RunLine {
    let fit: Option<Identification> = answer(&path.with_extension("identification.json"));
    let began_ns = began_ns(&name);
    RunLine {
        machine: fit.map_or_else(String::new, |fit| fit.machine),
        began_s: began_ns.map(|ns| ns / 1_000_000_000),
        began: began_ns.and_then(trunnion::moment::minute).unwrap_or_default(),
        found: written(path),
        removed: why,
        name,
        ..RunLine::default()
    }
}

/// When a run began, from its name: `CYCLE-YYYYMMDDThhmmssZ`, with a number behind it where two began in a second.
fn began_ns(name: &str) -> Option<i64> {
    name.split('-')
        .filter_map(|part| {
            let (date, time) = part.strip_suffix('Z')?.split_once('T')?;
            let cut = |text: &str, ends: [usize; 2]| {
                let [a, b] = ends;
                Some([text.get(..a)?.to_owned(), text.get(a..b)?.to_owned(), text.get(b..)?.to_owned()])
            };
            let (date, time) = (cut(date, [4, 6])?.join("-"), cut(time, [2, 4])?.join(":"));
            parse_timestamp(&format!("{date}T{time}Z"))
        })
        .next()
}

/// What the service found in this recording; `None` where it analysed none, or another that was here before.
pub fn written(path: &Path) -> Option<RunFound> {
    match kept_story::found_in(path) {
        Kept::Found(found) => Some(*found),
        Kept::Nothing => of_answers(path),
        // The answers next to it are those of the story.
        Kept::OfOthers => None,
    }
}

/// The files that this depends on.
pub fn written_in(path: &Path) -> [PathBuf; 4] {
    let answers = ["identification.json", "diagnosis.json"].map(|ending| path.with_extension(ending));
    let [fit, diagnosis] = answers;
    [path.to_owned(), kept_story::path_of(path), fit, diagnosis]
}

/// The same of the answers that versions without a kept story left.
fn of_answers(path: &Path) -> Option<RunFound> {
    let fit: Identification = answer(&path.with_extension("identification.json"))?;
    let diagnosis: Diagnosis = answer(&path.with_extension("diagnosis.json"))?;
    Some(in_short(&fit, &diagnosis))
}

fn answer<T: DeserializeOwned>(path: &Path) -> Option<T> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_whose_samples_are_gone_is_dated_by_its_name() {
        let expected = parse_timestamp("2026-11-23T14:10:58Z");
        assert!(expected.is_some());
        assert_eq!(began_ns("r-test-static-20261123T141058Z"), expected);
        assert_eq!(began_ns("r-test-static-20261123T141058Z-2"), expected);
        assert_eq!(began_ns("monday"), None);
    }
}
