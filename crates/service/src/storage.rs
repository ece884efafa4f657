//! The folder of the recordings: one writer, room for the next cycle, a budget.
//!
//! Raw recordings go first, the oldest before all; reports, states and models stay. What has no report yet is never removed, nor is
//! the newest run.

mod config;
mod lock;
mod retention;
mod space;
mod today;

pub use config::StorageConfig;
pub(crate) use lock::try_writing;
pub use lock::{FolderLock, LockError};
pub use retention::Removed;
pub(crate) use space::free_mb;
pub use space::{Need, Room};
pub use today::{Today, WallClock};

use crate::run_record::{Known, removed_from};
use retention::{Stored, doubt, to_remove};
use std::path::{Path, PathBuf};

/// What came of tidying.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tidied {
    /// What went.
    pub removed: Vec<Removed>,
    /// Why nothing goes at present, or not all that should, for a person.
    pub doubt: Option<String>,
}

/// The folder of the recordings.
#[derive(Clone, Debug)]
pub struct Storage {
    folder: PathBuf,
    config: StorageConfig,
    tries: u32,
}

impl Storage {
    /// A run of which so many analyses failed has no report to come.
    pub fn new(folder: &Path, config: StorageConfig, tries: u32) -> Self {
        Self { folder: folder.into(), config, tries }
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Free, MB.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn free_mb(&self) -> std::io::Result<f64> {
        free_mb(&self.folder)
    }

    /// Makes room for what a cycle needs, and says whether there is.
    ///
    /// # Errors
    /// When the system does not say how much is free.
    pub fn room(&self, need: Need, today: Today) -> std::io::Result<(Room, Tidied)> {
        let wanted_mb = need.mb() + self.config.keep_free_mb;
        let tidied = match self.free_mb()? < wanted_mb {
            true => self.remove(wanted_mb, today)?,
            false => Tidied::default(),
        };
        Ok((self.room_for(need)?, tidied))
    }

    /// Whether there is room for a cycle; for none with [`Need::NOTHING`].
    ///
    /// # Errors
    /// When the system does not say how much is free.
    pub fn room_for(&self, need: Need) -> std::io::Result<Room> {
        Ok(Room::of(self.free_mb()?, need, self.config.keep_free_mb))
    }

    /// Removes what is beyond budget and age.
    ///
    /// # Errors
    /// When the system does not say how much is free.
    pub fn tidy(&self, today: Today) -> std::io::Result<Tidied> {
        self.remove(0.0, today)
    }

    /// A person allows removal by a budget or an age; without either, nothing goes.
    fn remove(&self, wanted_mb: f64, today: Today) -> std::io::Result<Tidied> {
        if self.config.budget_mb.is_none() && self.config.keep.is_none() {
            return Ok(Tidied::default());
        }
        let stored = Stored::read(&self.folder, self.tries);
        let missing_mb = (wanted_mb - self.free_mb()?).max(0.0);
        let going = to_remove(&stored, &self.config, missing_mb, today);
        let due = going.len();
        let (mut removed, mut refused) = (Vec::new(), None);
        for (index, why) in going {
            match stored[index].remove(&why, today.wall) {
                Ok(gone) => removed.push(gone),
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        let refused = refused.map(|why| {
            format!(
                "{} of {due} runs whose samples should go were removed; the first that stays, {why}",
                removed.len()
            )
        });
        Ok(Tidied { removed, doubt: doubt(&stored, today.wall).or(refused) })
    }

    /// Runs of the folder with their samples, and runs whose samples were removed.
    pub fn runs(&self) -> (usize, usize) {
        (Known::read(&self.folder).runs.len(), removed_from(&self.folder).len())
    }
}

#[cfg(test)]
mod tests {
    use super::config::DAY;
    use super::*;
    use crate::run_record;
    use std::time::SystemTime;
    use trunnion::results::{RunRecord, RunState};

    #[test]
    fn samples_go_by_the_budget_and_reports_stay() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::UNIX_EPOCH + 20_000 * DAY;
        let at = |name: &str| folder.path().join(name);
        for (age, name) in ["d", "c", "b", "a"].into_iter().enumerate() {
            let recording = at(&format!("{name}.mcap"));
            std::fs::write(&recording, vec![0; 1_000_000]).unwrap();
            let written = now - DAY * u32::try_from(age).unwrap();
            std::fs::File::options().write(true).open(&recording).unwrap().set_modified(written).unwrap();
            std::fs::write(recording.with_extension("html"), "report").unwrap();
            let state = if name == "b" { RunState::Recorded } else { RunState::Done };
            let parts = if name == "a" { vec!["a-2.mcap".into()] } else { Vec::new() };
            run_record::write(&recording, &RunRecord { state, parts, ..RunRecord::default() }).unwrap();
        }
        std::fs::write(at("a-2.mcap"), vec![0; 1_000_000]).unwrap();
        let config = StorageConfig { budget_mb: Some(2.5), ..StorageConfig::default() };
        let removed = Storage::new(folder.path(), config, 3).tidy(Today::of(now)).unwrap().removed;
        let names: Vec<&str> = removed.iter().map(|removed| removed.run.as_str()).collect();
        // a with its second part, not b, which has no report yet.
        assert_eq!(names, ["a", "c"]);
        assert!(removed[0].mb > 1.9 && removed[0].why.contains("budget_mb of [storage]"), "{removed:?}");
        for (name, is_there) in [("a", false), ("a-2", false), ("b", true), ("c", false), ("d", true)] {
            assert_eq!(at(&format!("{name}.mcap")).exists(), is_there, "{name}");
        }
        assert!(at("a.html").exists() && at("c.html").exists());
        let why = run_record::read(&at("a.mcap")).unwrap().removed.unwrap();
        assert!(why.starts_with("2024-10-04T00:00:00Z: the recordings took more than 2.5 MB"), "{why}");
        let nothing = Storage::new(folder.path(), StorageConfig::default(), 3).tidy(Today::of(now)).unwrap();
        assert_eq!(nothing, Tidied::default());
    }

    #[test]
    fn a_run_of_which_some_files_are_gone_already_goes_as_soon_as_the_others_can() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::UNIX_EPOCH + 20_000 * DAY;
        let at = |name: &str| folder.path().join(name);
        let write = |name: &str, age: u32| {
            std::fs::write(at(name), vec![0; 1_000_000]).unwrap();
            let file = std::fs::File::options().write(true).open(at(name)).unwrap();
            file.set_modified(now - DAY * age).unwrap();
        };
        for (name, age) in [("a.mcap", 2), ("a-3.mcap", 2), ("b.mcap", 1), ("c.mcap", 0)] {
            write(name, age);
        }
        let done = RunRecord { state: RunState::Done, ..RunRecord::default() };
        // A part of `a` that cannot be removed as a file is: it is a folder. What `b` was joined from was removed by hand.
        std::fs::create_dir(at("a-2.mcap")).unwrap();
        let parts = vec!["a-2.mcap".into(), "a-3.mcap".into()];
        run_record::write(&at("a.mcap"), &RunRecord { parts, ..done.clone() }).unwrap();
        let joined_from = vec!["b-before.mcap".into()];
        run_record::write(&at("b.mcap"), &RunRecord { joined_from, ..done.clone() }).unwrap();
        run_record::write(&at("c.mcap"), &done).unwrap();
        let config = StorageConfig { budget_mb: Some(1.5), ..StorageConfig::default() };
        let storage = Storage::new(folder.path(), config, 3);
        let removed = |tidied: &Tidied| {
            tidied.removed.iter().map(|removed| removed.run.clone()).collect::<Vec<_>>().join(" ")
        };
        let tidied = storage.tidy(Today::of(now)).unwrap();
        assert_eq!(removed(&tidied), "b");
        assert!(tidied.doubt.unwrap().contains("a-2.mcap"));
        assert!(at("a.mcap").exists() && !at("a-3.mcap").exists());
        std::fs::remove_dir(at("a-2.mcap")).unwrap();
        write("a-2.mcap", 2);
        let tidied = storage.tidy(Today::of(now)).unwrap();
        assert_eq!((removed(&tidied).as_str(), tidied.doubt), ("a", None));
        assert!(!at("a.mcap").exists() && !at("a-2.mcap").exists() && at("c.mcap").exists());
    }
}
