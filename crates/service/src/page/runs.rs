//! Recordings behind the page: found by listing, analysed by a process of its own when something is asked of them.
//!
//! A name from a call is compared with the names of the list and never becomes part of a path.

mod list;
#[cfg(test)]
mod tests;

use super::analyst::PageAnalyst;
use super::answer::Refusal;
use super::question::{Asks, NoAnswer, Question};
use super::stamp::{Stamps, files_of, own_model};
use crate::board::Board;
use crate::cycles::{Choice, Cycles};
use crate::stamp::{Stamp, stamp};
use crate::{kept_story, run_record};
use hyper::body::Bytes;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Semaphore;
use trunnion::results::{AlarmsNow, CorrectionEntered, RunFound, RunLine, RunList, RunListFormat};
use trunnion::{Model, history};
use trunnion_core::chain;

/// Answers that are kept, bytes; what-if of 10 000 poses has 9 MB, a report 1 MB.
const MOST_KEPT: usize = 64 << 20;
/// Analyses that may wait for the one that runs.
const MOST_WAITING: usize = 8;

/// Recordings, and what was found in them.
pub struct Runs {
    place: Place,
    /// The model that a run without one of its own is judged by; the base model without it.
    model: Option<PathBuf>,
    /// Cycles whose runs are judged by the model of each.
    cycles: Option<Cycles>,
    analyst: PageAnalyst,
    kept: Mutex<VecDeque<KeptAnswer>>,
    lines: Mutex<BTreeMap<PathBuf, (Stamp, RunLine)>>,
    /// What was found here in a recording as it was then.
    found: Mutex<BTreeMap<PathBuf, (Stamp, RunFound)>>,
    /// What the service left of an analysis in files as they were then.
    written: Mutex<BTreeMap<PathBuf, (Stamps, Option<RunFound>)>>,
    /// What was published last.
    alarms: Mutex<AlarmsNow>,
    /// One analysis at a time: the computer also measures.
    analysing: Arc<Semaphore>,
    waiting: Arc<Semaphore>,
}

/// Where the recordings are.
enum Place {
    Folder(PathBuf),
    Files(Vec<PathBuf>),
}

/// An answer that is given again.
struct KeptAnswer {
    recording: PathBuf,
    asks: Asks,
    stamps: Stamps,
    text: Bytes,
}

impl Runs {
    /// All recordings of a folder, whenever they come.
    pub fn of_folder(folder: impl Into<PathBuf>, model: Option<PathBuf>, analyst: PageAnalyst) -> Self {
        Self::new(Place::Folder(folder.into()), model, analyst)
    }

    /// These recordings alone.
    pub fn of_files(files: Vec<PathBuf>, model: Option<PathBuf>, analyst: PageAnalyst) -> Self {
        Self::new(Place::Files(files), model, analyst)
    }

    fn new(place: Place, model: Option<PathBuf>, analyst: PageAnalyst) -> Self {
        Self {
            place,
            model,
            cycles: None,
            analyst,
            kept: Mutex::default(),
            lines: Mutex::default(),
            found: Mutex::default(),
            written: Mutex::default(),
            alarms: Mutex::default(),
            analysing: Arc::new(Semaphore::new(1)),
            waiting: Arc::new(Semaphore::new(MOST_WAITING)),
        }
    }

    /// The same judged as the service judges: by the model of the cycle that was measured, of the first where that is not among them.
    #[must_use]
    pub fn judged_by(self, cycles: Cycles) -> Self {
        Self { cycles: Some(cycles), ..self }
    }

    /// The model file of a run without one of its own; `None` is the base model.
    fn model_of(&self, recording: &Path) -> Option<PathBuf> {
        let Some(cycles) = &self.cycles else { return self.model.clone() };
        let of_cycle = cycles.judged_by(&list::cycle_of(recording));
        of_cycle.or_else(|| cycles.first().map(Choice::judged_by))?.file
    }

    /// One line for each recording, in order of time.
    pub fn list(&self) -> RunList {
        let paths = self.paths();
        let mut runs: Vec<RunLine> = paths
            .into_iter()
            .map(|(name, path)| RunLine { found: self.found(&path), ..self.line(name, path) })
            .collect();
        runs.extend(self.removed().into_iter().map(|(name, path, why)| list::removed(name, &path, why)));
        runs.sort_by(|a, b| (a.began_s, &a.name).cmp(&(b.began_s, &b.name)));
        RunList { format: RunListFormat::V1, runs }
    }

    /// The recordings that a forecast of the next day is made from, oldest first, with the name of the last; or why they do not allow one.
    pub fn days(&self) -> Result<Result<(String, Vec<PathBuf>), String>, Refusal> {
        let history = history::of_found(&self.list().runs, &self.corrections()?);
        let days = match history::days(&history, 0) {
            Ok(days) => days,
            Err(why_not) => return Ok(Err(why_not)),
        };
        let names: Vec<&String> = days.iter().map(|&index| &history.runs[index].run).collect();
        // Of a run whose samples were removed nothing can be fitted.
        let recordings: Vec<PathBuf> = names.iter().filter_map(|name| self.path(name).ok()).collect();
        let Some(last) = names.last().filter(|last| self.path(last).is_ok()) else {
            let which = names.last().map_or("these runs", |last| last.as_str());
            return Ok(Err(format!("the samples of {which} were removed")));
        };
        let removed = names.len() - recordings.len();
        if removed > 0 {
            tracing::info!(
                "a forecast without {removed} of {} runs, whose samples were removed",
                names.len()
            );
        }
        Ok(Ok((last.to_string(), recordings)))
    }

    /// The last run that is compared, and the recording of the one before it; `None` before there are two.
    pub fn last_two(&self) -> Result<Option<(String, PathBuf)>, Refusal> {
        let history = history::of_found(&self.list().runs, &self.corrections()?);
        let Some(change) = history.change else { return Ok(None) };
        let path = |name: &String| self.path(name).map_err(|_| Refusal::NotCompared { name: name.clone() });
        let (earlier, _) = (path(&change.from)?, path(&change.to)?);
        Ok(Some((change.to, earlier)))
    }

    /// What of the newest run lies outside the limits that the runs before it set.
    fn alarms(&self) -> Result<AlarmsNow, Refusal> {
        Ok(history::alarms(&history::of_found(&self.list().runs, &self.corrections()?)))
    }

    /// The same on the board and, where it changed, in the log. Reads recordings: call it where blocking is allowed.
    pub fn publish_alarms(&self, board: &Board) -> Result<(), Refusal> {
        // Held, so that what was found later is published later.
        let mut before = lock(&self.alarms);
        let now = self.alarms()?;
        let names: Vec<&str> = now.alarms.iter().map(|alarm| alarm.name.as_str()).collect();
        if !names.is_empty() && now != *before {
            tracing::warn!(run = now.run, values = names.join(", "), "outside the limits of the runs before");
        }
        board.publish(&now);
        *before = now;
        Ok(())
    }

    /// Corrections that were entered, kept next to the recordings.
    pub fn corrections(&self) -> Result<Vec<CorrectionEntered>, Refusal> {
        let Some(folder) = self.folder() else { return Ok(Vec::new()) };
        history::corrections(&folder).map_err(|failure| Refusal::Failed(chain(&failure)))
    }

    /// Keeps that a correction was entered, of the machine of the history.
    pub fn enter_correction(&self, wall_ns: i64, by: &str, what: &str) -> Result<(), Refusal> {
        let machine = history::of_found(&self.list().runs, &[]).machine;
        if machine.is_empty() {
            return Err(Refusal::NotNow("analyse a run first: it says which machine was corrected"));
        }
        let folder = self.folder().ok_or(Refusal::NotNow("there is no recording to keep it next to"))?;
        let correction = history::entered(machine, wall_ns, by, what)
            .map_err(|failure| Refusal::Wrong(chain(&failure)))?;
        let kept = history::enter_correction(&folder, &correction);
        kept.map(|_| ()).map_err(|failure| Refusal::Failed(chain(&failure)))
    }

    /// Where recordings are: of single ones that of the first.
    fn folder(&self) -> Option<PathBuf> {
        match &self.place {
            Place::Folder(folder) => Some(folder.clone()),
            Place::Files(files) => files.first().and_then(|path| path.parent()).map(Path::to_path_buf),
        }
    }

    /// What was found in the recording that is there now.
    fn found(&self, path: &Path) -> Option<RunFound> {
        let now = stamp(path);
        if let Some((_, found)) = lock(&self.found).get(path).filter(|(of, _)| *of == now) {
            return Some(found.clone());
        }
        let stamps = Stamps::of(list::written_in(path));
        if let Some((_, found)) = lock(&self.written).get(path).filter(|(of, _)| *of == stamps) {
            return found.clone();
        }
        let found = list::written(path);
        lock(&self.written).insert(path.into(), (stamps, found.clone()));
        found
    }

    fn line(&self, name: String, path: PathBuf) -> RunLine {
        let stamp = stamp(&path);
        if let Some((known, line)) = lock(&self.lines).get(&path)
            && *known == stamp
        {
            return line.clone();
        }
        let line = list::read(name, &path);
        lock(&self.lines).insert(path, (stamp, line.clone()));
        line
    }

    fn paths(&self) -> Vec<(String, PathBuf)> {
        match &self.place {
            Place::Folder(folder) => list::recordings(folder),
            Place::Files(files) => files.iter().map(|path| (list::name_of(path), path.clone())).collect(),
        }
    }

    fn path(&self, name: &str) -> Result<PathBuf, Refusal> {
        if let Some((_, path)) = self.paths().into_iter().find(|(known, _)| known == name) {
            return Ok(path);
        }
        match self.removed().into_iter().find(|(known, ..)| known == name) {
            Some((.., why)) => Err(Refusal::Removed { why }),
            None => Err(Refusal::Unknown { what: "run", name: name.into() }),
        }
    }

    /// Where the recording of this name is, or was before its samples were removed.
    pub fn place_of(&self, name: &str) -> Option<PathBuf> {
        let there = self.paths().into_iter().find(|(known, _)| known == name).map(|(_, path)| path);
        there
            .or_else(|| self.removed().into_iter().find(|(known, ..)| known == name).map(|(_, path, _)| path))
    }

    /// Runs whose samples were removed: name, where the recording was, when and why.
    fn removed(&self) -> Vec<(String, PathBuf, String)> {
        match &self.place {
            Place::Folder(folder) => list::removed_from(folder),
            Place::Files(_) => Vec::new(),
        }
    }

    /// The report that a run left when its samples were removed; `None` for any other.
    pub fn left_report(&self, name: &str) -> Option<String> {
        let (_, path, _) = self.removed().into_iter().find(|(known, ..)| known == name)?;
        std::fs::read_to_string(path.with_extension("html")).ok()
    }

    /// Asks something of the run of this name.
    pub async fn ask(self: &Arc<Self>, name: &str, asks: Asks) -> Result<Bytes, Refusal> {
        // What the files say, off the threads that serve the page: a share on the network may be slow.
        let (runs, name) = (self.clone(), name.to_owned());
        let looking = tokio::task::spawn_blocking(move || {
            let path = runs.path(&name)?;
            let known = runs.known(&path, &asks);
            Ok::<_, Refusal>((path, asks, known))
        });
        let (path, asks, known) = looking.await.map_err(|_| Refusal::Broken("page"))??;
        if let Some(text) = known {
            return Ok(text);
        }
        let waits = self.waiting.clone().try_acquire_owned().map_err(|_| Refusal::Busy)?;
        let turn = self.analysing.clone().acquire_owned().await.map_err(|_| Refusal::Broken("page"))?;
        let runs = self.clone();
        let answering = tokio::task::spawn_blocking(move || {
            let answer = runs.answer(path, asks);
            drop((turn, waits));
            answer
        });
        answering.await.map_err(|_| Refusal::Broken("analysis"))?
    }

    fn answer(&self, recording: PathBuf, asks: Asks) -> Result<Bytes, Refusal> {
        let (stamps, before) = (self.stamps(&recording, &asks), stamp(&recording));
        let question = Question { model: self.model_of(&recording), recording, asks };
        let reply = self.analyst.ask(&question).map_err(|why| match why {
            NoAnswer::Failed(why) => Refusal::Failed(why),
            NoAnswer::NotTrusted(why) => Refusal::NotTrusted(why),
        })?;
        let Question { recording, asks, .. } = question;
        lock(&self.found).insert(recording.clone(), (before, reply.found));
        let text = Bytes::from(reply.text);
        if asks.is_kept() {
            let of_run = |answer: &&KeptAnswer| answer.recording == recording;
            let stamped = |answer: &KeptAnswer| (answer.asks.clone(), answer.stamps.clone());
            let mut over: Vec<(Asks, Stamps)> = lock(&self.kept).iter().filter(of_run).map(stamped).collect();
            // Looks at files: not while others wait for the lock.
            over.retain(|(of, stamps)| *of == asks || *stamps != self.stamps(&recording, of));
            let is_over = |asks: &Asks| over.iter().any(|(of, _)| of == asks);
            let mut kept = lock(&self.kept);
            kept.retain(|answer| answer.recording != recording || !is_over(&answer.asks));
            kept.push_back(KeptAnswer { recording, asks, stamps, text: text.clone() });
            while kept.iter().map(|answer| answer.text.len()).sum::<usize>() > MOST_KEPT {
                kept.pop_front();
            }
        }
        Ok(text)
    }

    /// Of every file that the answer comes from: each recording with its parts, its state, and the model that it is judged by.
    fn stamps(&self, recording: &Path, asks: &Asks) -> Stamps {
        let of_run = |recording: &PathBuf| files_of(recording, self.model_of(recording));
        let others = asks.others().iter().filter(|other| *other != recording);
        Stamps::of(std::iter::once(&recording.to_owned()).chain(others).flat_map(of_run))
    }

    /// The story that the analysis of the service left, unless recording or model changed since.
    fn story_of_analysis(&self, recording: &Path) -> Option<Bytes> {
        let own = own_model(recording);
        let judged_by = if own.exists() { Some(own) } else { self.model_of(recording) };
        let model = match judged_by {
            Some(path) => Model::load(path).ok()?,
            None => Model::base(&trunnion_record::read_header(recording).ok()?.machine_name),
        };
        let files = run_record::files_of(recording);
        let text = kept_story::read(recording, &files, model.text())?;
        lock(&self.found).insert(recording.into(), (stamp(recording), list::written(recording)?));
        Some(text.into())
    }

    /// An answer that needs no analysis.
    fn known(&self, recording: &Path, asks: &Asks) -> Option<Bytes> {
        let story = || (*asks == Asks::Story).then(|| self.story_of_analysis(recording)).flatten();
        self.kept(recording, asks).or_else(story)
    }

    /// What the same question got, unless a recording, its state or a model changed since.
    fn kept(&self, recording: &Path, asks: &Asks) -> Option<Bytes> {
        let same = |answer: &&KeptAnswer| answer.recording == recording && answer.asks == *asks;
        let (stamps, text) =
            lock(&self.kept).iter().find(same).map(|known| (known.stamps.clone(), known.text.clone()))?;
        (stamps == self.stamps(recording, asks)).then_some(text)
    }

    /// Ends the analysis that is under way.
    pub(super) fn stop(&self) {
        self.analyst.stop();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
