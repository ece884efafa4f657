//! What was worked out of runs is kept next to the last of them, `NAME.history.jsonl`, and taken again as long as it is of the same: the
//! contents of every recording, the model, the build of the program.

use crate::{Error, Model, files, identity};
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use trunnion_results::to_json_line;

const ENDING: &str = "history.jsonl";
/// What is asked of several runs, in words.
pub(super) const CHANGE: &str = "what changed";
pub(super) const FORECAST: &str = "the next day";
/// Answers that are kept of a run: the run, what changed and the forecast after it, by the last four models.
const MOST_KEPT: usize = 12;

/// What is being worked out, of how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Working<'a> {
    /// Parts that are done.
    pub done: usize,
    /// All parts.
    pub total: usize,
    /// This part: the name of a run, or what is asked of several.
    pub what: &'a str,
}

/// Answers of runs, kept ones where they hold; what is worked out is kept.
pub struct Keeper<'a> {
    shows: Box<dyn FnMut(Working<'_>) + 'a>,
    pub(super) done: usize,
    pub(super) total: usize,
    recorded: BTreeMap<PathBuf, Option<Recorded>>,
    not_kept: Option<Error>,
}

/// What a recording is.
#[derive(Clone)]
struct Recorded {
    machine: String,
    sha256: String,
}

/// What an answer is of.
#[derive(Serialize)]
struct Of<'a> {
    program: &'a str,
    kind: &'a str,
    /// Name and SHA-256 of each file of each run: sentences name runs.
    runs: Vec<Vec<(String, String)>>,
    model: &'a str,
}

/// An answer in its file.
#[derive(Serialize, Deserialize)]
struct Line<T> {
    /// SHA-256 of [`Of`].
    of: String,
    answer: T,
}

/// Where an answer is kept, and what it is of.
pub(super) struct Place {
    path: PathBuf,
    of: String,
}

impl Default for Keeper<'_> {
    fn default() -> Self {
        Self::new(|_| {})
    }
}

impl<'a> Keeper<'a> {
    /// One that calls `shows` before anything that takes time.
    pub fn new(shows: impl FnMut(Working<'_>) + 'a) -> Self {
        Self { shows: Box::new(shows), done: 0, total: 0, recorded: BTreeMap::new(), not_kept: None }
    }

    /// Why something was not kept, the first; `None` where all is.
    pub fn not_kept(&self) -> Option<&Error> {
        self.not_kept.as_ref()
    }

    /// The kept answer to a question of this kind about runs, else what `work` gives; `what` says it to a person.
    pub(super) fn answer<T: Serialize + DeserializeOwned + PartialEq, E>(
        &mut self,
        (kind, what): (&str, &str),
        runs: &[Vec<PathBuf>],
        model: Option<&Model>,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        // Before the work: of what is still being copied the digest is that of a part, and of what is read then the whole.
        let place = self.place(kind, runs, model);
        let kept = place.as_ref().and_then(Place::read);
        self.done += 1;
        if let Some(kept) = kept {
            return Ok(kept);
        }
        (self.shows)(Working { done: self.done - 1, total: self.total, what });
        let answer = work()?;
        if let Some(Err(failure)) = place.map(|place| place.write(&answer)) {
            self.not_kept.get_or_insert(failure);
        }
        Ok(answer)
    }

    /// `None` where the answer depends on more than these files: a recording that only names its machine, a points file with its setup.
    pub(super) fn place(
        &mut self,
        kind: &str,
        runs: &[Vec<PathBuf>],
        model: Option<&Model>,
    ) -> Option<Place> {
        let mut machine = String::new();
        let mut of_runs = Vec::new();
        for files in runs {
            let mut of_run = Vec::new();
            for file in files {
                let recorded = self.recorded(file)?;
                of_run.push((file.file_name()?.to_string_lossy().into_owned(), recorded.sha256));
                machine = recorded.machine;
            }
            of_runs.push(of_run);
        }
        let base = Model::base(&machine);
        let model = model.unwrap_or(&base).text();
        let of =
            serde_json::to_string(&Of { program: identity::program()?, kind, runs: of_runs, model }).ok()?;
        let last = runs.last()?.first()?;
        Some(Place { path: last.with_extension(ENDING), of: identity::sha256_of(of.as_bytes()) })
    }

    fn recorded(&mut self, file: &Path) -> Option<Recorded> {
        let read = || {
            let header = trunnion_record::read_header(file).ok()?;
            header.machine()?.ok()?;
            Some(Recorded { machine: header.machine_name, sha256: identity::sha256(file).ok()? })
        };
        self.recorded.entry(file.into()).or_insert_with(read).clone()
    }
}

impl Place {
    fn read<T: DeserializeOwned>(&self) -> Option<T> {
        let text = std::fs::read_to_string(&self.path).ok()?;
        let line = text.lines().rev().find(|line| of_line(line).as_ref() == Some(&self.of))?;
        serde_json::from_str(line).ok().map(|Line { answer, .. }| answer)
    }

    pub(super) fn write<T: Serialize + DeserializeOwned + PartialEq>(&self, answer: &T) -> Result<(), Error> {
        let failed = |why: serde_json::Error| Error::write(&self.path)(why.into());
        let line = to_json_line(&Line { of: self.of.clone(), answer }).map_err(failed)?;
        // What JSON does not hold, as a number that is not finite, would come back another.
        if !serde_json::from_str::<Line<T>>(&line).is_ok_and(|read| read.answer == *answer) {
            return Ok(());
        }
        let before = std::fs::read_to_string(&self.path).unwrap_or_default();
        let others = before.lines().filter(|line| of_line(line).is_some_and(|of| of != self.of));
        let mut kept: Vec<&str> = others.collect();
        kept.drain(..kept.len().saturating_sub(MOST_KEPT - 1));
        let text: String = kept.iter().flat_map(|line| [line, "\n"]).chain([line.as_str()]).collect();
        files::write_whole(&self.path, &text)
    }
}

/// What a line is of; `None` for one that was cut.
fn of_line(line: &str) -> Option<String> {
    serde_json::from_str::<Line<IgnoredAny>>(line).ok().map(|line| line.of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use trunnion_results::{HistoryRun, Parameter};

    fn run(numbers: &[f64]) -> HistoryRun {
        let of =
            |value: &f64| Parameter { value: Some(*value), u: Some(value.abs()), ..Parameter::default() };
        HistoryRun {
            rms_um: numbers.first().copied(),
            values: numbers.iter().map(of).collect(),
            ..HistoryRun::default()
        }
    }

    fn bits(run: &HistoryRun) -> Vec<Option<u64>> {
        let of = |value: &Parameter| [value.value, value.u];
        run.values.iter().flat_map(of).chain([run.rms_um]).map(|number| number.map(f64::to_bits)).collect()
    }

    proptest! {
        #[test]
        fn what_is_kept_comes_back_to_the_bit_or_is_not_kept(numbers in prop::collection::vec(any::<u64>(), 1..8)) {
            let folder = tempfile::tempdir().unwrap();
            let place = |of: &str| Place { path: folder.path().join("day.history.jsonl"), of: of.into() };
            let worked_out = run(&numbers.iter().map(|bits| f64::from_bits(*bits)).collect::<Vec<_>>());
            place("one").write(&worked_out).unwrap();
            let finite = bits(&worked_out).iter().flatten().all(|bits| f64::from_bits(*bits).is_finite());
            let kept = place("one").read::<HistoryRun>();
            prop_assert_eq!(kept.is_some(), finite);
            prop_assert!(kept.is_none_or(|kept| bits(&kept) == bits(&worked_out)));
            prop_assert_eq!(place("another").read::<HistoryRun>(), None);
        }
    }

    #[test]
    fn the_latest_answers_stay_and_a_line_that_was_cut_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let place = |of: usize| Place { path: folder.path().join("day.history.jsonl"), of: of.to_string() };
        for of in 0..20 {
            place(of).write(&run(&[of as f64])).unwrap();
        }
        let there = |of: usize| place(of).read::<HistoryRun>() == Some(run(&[of as f64]));
        assert_eq!((0..20).filter(|of| there(*of)).collect::<Vec<_>>(), (8..20).collect::<Vec<_>>());
        let path = place(0).path;
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() - 9]).unwrap();
        assert!(there(18) && !there(19));
        place(19).write(&run(&[19.0])).unwrap();
        assert!(there(18) && there(19));
    }
}
