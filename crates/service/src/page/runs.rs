//! Recordings behind the page: found by listing, analysed when they are asked for.
//!
//! A name from a call is compared with the names of the list and never becomes part of a path.

mod list;

use super::answer::Refusal;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;
use tokio::sync::Semaphore;
use trunnion::results::{RunFound, RunLine, RunList, RunListFormat, sentences};
use trunnion::{Compared, Model};

/// Analysed runs that are kept; a run of 10 000 points needs some 30 MB.
const MOST_OPEN: usize = 4;
/// Analyses that may wait for the one that runs.
const MOST_WAITING: usize = 8;

/// Recordings, and what was found in them.
pub struct Runs {
    place: Place,
    /// The model that a run without one of its own is judged by; the base model without it.
    model: Option<PathBuf>,
    open: Mutex<VecDeque<(PathBuf, Arc<Open>)>>,
    lines: Mutex<BTreeMap<PathBuf, (Stamp, RunLine)>>,
    found: Mutex<BTreeMap<PathBuf, RunFound>>,
    /// One analysis at a time: the computer also measures.
    analysing: Semaphore,
    waiting: Semaphore,
}

/// Where the recordings are.
enum Place {
    Folder(PathBuf),
    Files(Vec<PathBuf>),
}

/// Changes when a file does.
type Stamp = Option<(SystemTime, u64)>;

/// An analysed run.
pub struct Open {
    /// The answer, with everything behind it.
    pub compared: Compared,
    /// The model file that belongs to the run alone.
    pub model_path: PathBuf,
    stamps: [Stamp; 2],
}

impl Runs {
    /// All recordings of a folder, whenever they come.
    pub fn of_folder(folder: impl Into<PathBuf>, model: Option<PathBuf>) -> Self {
        Self::new(Place::Folder(folder.into()), model)
    }

    /// These recordings alone.
    pub fn of_files(files: Vec<PathBuf>, model: Option<PathBuf>) -> Self {
        Self::new(Place::Files(files), model)
    }

    fn new(place: Place, model: Option<PathBuf>) -> Self {
        Self {
            place,
            model,
            open: Mutex::default(),
            lines: Mutex::default(),
            found: Mutex::default(),
            analysing: Semaphore::new(1),
            waiting: Semaphore::new(MOST_WAITING),
        }
    }

    /// One line for each recording, in order of time.
    pub fn list(&self) -> RunList {
        let paths = self.paths();
        let mut runs: Vec<RunLine> = paths
            .into_iter()
            .map(|(name, path)| {
                let found = lock(&self.found).get(&path).cloned().or_else(|| list::written(&path));
                RunLine { found, ..self.line(name, path) }
            })
            .collect();
        runs.extend(self.removed().into_iter().map(|(name, path, why)| list::removed(name, &path, why)));
        runs.sort_by(|a, b| (a.began_s, &a.name).cmp(&(b.began_s, &b.name)));
        RunList { format: RunListFormat::V1, runs }
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

    /// The run of this name, analysed unless it is already.
    pub async fn open(self: &Arc<Self>, name: &str) -> Result<Arc<Open>, Refusal> {
        let path = self.path(name)?;
        if let Some(open) = self.kept(&path) {
            return Ok(open);
        }
        self.alone(move |runs| runs.current(&path)).await
    }

    /// Puts an effect into the model of a run; `by` is who does it, `date` when.
    pub async fn add(
        self: &Arc<Self>,
        name: &str,
        effect: String,
        by: String,
        date: String,
    ) -> Result<Arc<Open>, Refusal> {
        let path = self.path(name)?;
        self.alone(move |runs| {
            let open = runs.trusted(&path)?;
            let step = open.compared.diagnosed().add(&effect)?.dated(&date)?.by(&by)?;
            step.model().save(&open.model_path)?;
            tracing::info!(model = %open.model_path.display(), effect, by, "added from the page");
            runs.analyse(path)
        })
        .await
    }

    /// Takes an effect out of the model of a run.
    pub async fn remove(
        self: &Arc<Self>,
        name: &str,
        effect: String,
        by: String,
        date: String,
    ) -> Result<Arc<Open>, Refusal> {
        let path = self.path(name)?;
        self.alone(move |runs| {
            let open = runs.trusted(&path)?;
            let smaller = open.compared.diagnosed().fit().remove(&effect, &date, Some(&by))?;
            smaller.model().save(&open.model_path)?;
            tracing::info!(model = %open.model_path.display(), effect, by, "removed from the page");
            runs.analyse(path)
        })
        .await
    }

    /// A run that a person may act on, with its model as it is now: another browser may have changed it while this one waited.
    fn trusted(&self, path: &Path) -> Result<Arc<Open>, Refusal> {
        let open = self.current(path)?;
        let doubts = open.compared.diagnosed().fit().experiment().plausibility();
        match doubts.is_empty() {
            true => Ok(open),
            false => Err(Refusal::NotTrusted(sentences::not_plausible(&doubts))),
        }
    }

    fn current(&self, path: &Path) -> Result<Arc<Open>, Refusal> {
        self.kept(path).map_or_else(|| self.analyse(path.into()), Ok)
    }

    /// Works on a thread of its own, one at a time.
    pub async fn alone<T: Send + 'static>(
        self: &Arc<Self>,
        work: impl FnOnce(&Self) -> Result<T, Refusal> + Send + 'static,
    ) -> Result<T, Refusal> {
        let _waits = self.waiting.try_acquire().map_err(|_| Refusal::Busy)?;
        let _runs = self.analysing.acquire().await.map_err(|_| Refusal::Broken("page"))?;
        let runs = self.clone();
        tokio::task::spawn_blocking(move || work(&runs)).await.map_err(|_| Refusal::Broken("analysis"))?
    }

    fn analyse(&self, path: PathBuf) -> Result<Arc<Open>, Refusal> {
        let model_path = path.with_extension("model.toml");
        let stamps = [stamp(&path), stamp(&model_path)];
        let experiment = trunnion::open(&path)?;
        let model = match &self.model {
            _ if model_path.exists() => Model::load(&model_path)?,
            Some(path) => Model::load(path)?,
            None => experiment.base_model(),
        };
        let compared = experiment.fit(&model)?.compare()?;
        lock(&self.found).insert(path.clone(), list::found(&compared.results()));
        let open = Arc::new(Open { compared, model_path, stamps });
        let mut kept = lock(&self.open);
        kept.retain(|(known, _)| *known != path);
        kept.push_back((path, open.clone()));
        if kept.len() > MOST_OPEN {
            kept.pop_front();
        }
        Ok(open)
    }

    /// The analysis of a recording, unless recording or model changed since.
    fn kept(&self, path: &Path) -> Option<Arc<Open>> {
        let open = lock(&self.open).iter().find(|(known, _)| known == path)?.1.clone();
        (open.stamps == [stamp(path), stamp(&open.model_path)]).then_some(open)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn stamp(path: &Path) -> Stamp {
    let about = std::fs::metadata(path).ok()?;
    Some((about.modified().ok()?, about.len()))
}
