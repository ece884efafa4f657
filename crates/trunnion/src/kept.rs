//! What was worked out of points is kept: fits, diagnoses and plans of the next cycle, each by all that it depends on. Asked again, it is
//! taken as it was, to the bit ([decision 0017](../../../docs/decisions/0017-what-was-worked-out-is-kept.md)).
//!
//! In memory, and in a folder of the program for its next start ([`keep_in`]). What cannot be kept is worked out again.

mod folder;
mod shelf;

use crate::identity;
use folder::Folder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use shelf::Shelf;
use std::fmt::Debug;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use trunnion_effects::{Model, ModelEffect};
use trunnion_engine::{Experiment, Identification};

/// The kind of fits.
const FIT: &str = "fit";

/// What this process worked out last.
static SHELF: Mutex<Shelf> = Mutex::new(Shelf::EMPTY);

/// Where this process keeps what outlives it.
static FOLDER: OnceLock<Folder> = OnceLock::new();

/// Keeps what is worked out in this folder too, from now on; the first call counts. Without one it is kept in memory alone.
pub fn keep_in(folder: &Path) {
    FOLDER.get_or_init(|| Folder::new(folder));
}

/// What was worked out of the points of one experiment; the digest of these is kept with them.
#[derive(Clone, Copy)]
pub(crate) struct Kept<'a> {
    pub points: &'a Experiment,
    pub digest: &'a OnceLock<String>,
}

/// What an answer depends on, for its digest. Options are those of the program, one set for each kind.
#[derive(Debug)]
#[expect(dead_code, reason = "read by Debug")]
struct Of<'a, W> {
    program: Option<&'a str>,
    kind: &'a str,
    /// SHA-256 of the points with their machine, setups, channels and names.
    points: &'a str,
    model: Judged<'a>,
    with: W,
}

/// A model as far as a fit depends on it: not what it remembers.
#[derive(Debug)]
#[expect(dead_code, reason = "read by Debug")]
struct Judged<'a> {
    machine: &'a str,
    effects: Vec<ModelEffect>,
}

impl Kept<'_> {
    /// What `work` gives, or gave before for this model and `with`, all else that it depends on.
    pub fn answer<T: Serialize + DeserializeOwned + PartialEq, E>(
        self,
        kind: &str,
        (model, with): (&Model, &impl Debug),
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let of = self.of(kind, model, with);
        if let Some(known) = read(&of) {
            return Ok(known);
        }
        let answer = work()?;
        keep(&of, &answer);
        Ok(answer)
    }

    /// The fit of a model with the default options, where one was made.
    pub fn fit(self, model: &Model) -> Option<Identification> {
        read(&self.of(FIT, model, &()))
    }

    /// Keeps such a fit.
    pub fn made(self, model: &Model, fit: &Identification) {
        keep(&self.of(FIT, model, &()), fit);
    }

    /// Digest of all that an answer depends on.
    fn of(self, kind: &str, model: &Model, with: &impl Debug) -> String {
        let points = self.digest.get_or_init(|| identity::sha256_of_shown(self.points));
        identity::sha256_of_shown(&Of {
            program: identity::program(),
            kind,
            points,
            model: judged(model),
            with,
        })
    }
}

fn read<T: DeserializeOwned>(of: &str) -> Option<T> {
    let on_shelf = shelf().read(of);
    if let Some(text) = on_shelf {
        return serde_json::from_str(&text).ok();
    }
    let text = folder()?.read(of)?;
    let answer = serde_json::from_str(&text).ok()?;
    shelf().keep(of, text);
    Some(answer)
}

fn keep<T: Serialize + DeserializeOwned + PartialEq>(of: &str, answer: &T) {
    let Ok(text) = serde_json::to_string(answer) else { return };
    // What JSON does not hold, as a number that is not finite, would come back another.
    if !serde_json::from_str::<T>(&text).is_ok_and(|read| read == *answer) {
        return;
    }
    if let Some(folder) = folder() {
        folder.keep(of, &text);
    }
    shelf().keep(of, text);
}

/// None for a program that cannot say which build it is: another one may read what it keeps.
fn folder() -> Option<&'static Folder> {
    identity::program().and(FOLDER.get())
}

fn shelf() -> MutexGuard<'static, Shelf> {
    SHELF.lock().unwrap_or_else(PoisonError::into_inner)
}

fn judged(model: &Model) -> Judged<'_> {
    let entry = |entry: &ModelEffect| ModelEffect { ladder: None, values: None, ..entry.clone() };
    Judged { machine: &model.machine, effects: model.effects.iter().map(entry).collect() }
}

#[cfg(test)]
mod tests;
