//! The disk while the service runs: room before a cycle, what is removed, and a recorder that cannot write, each said at once.

use super::watchdog::RECORDER;
use crate::board::Board;
use crate::cycles::Choice;
use crate::latest::Latest;
use crate::plant::topic;
use crate::storage::{FolderLock, LockError, Need, Removed, Room, Storage, Tidied, WallClock, try_writing};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio_util::sync::CancellationToken;
use tracing::{error, info, warn};
use trunnion::cycles::Pace;
use trunnion::results::{Published, SamplesRemoved, StorageNow, StorageState};
use trunnion_core::{Clock, chain};
use trunnion_record::RecorderStatus;

/// How often the recorder is looked at.
const LOOK: Duration = Duration::from_secs(1);
/// How often, in looks, the folder is tidied and the free space published.
const TIDY_EVERY: u32 = 60;
/// How long a cycle lasts of which the machine file does not say it, s: longer than any in `config/cycles`.
const UNKNOWN_CYCLE_S: f64 = 3600.0;

/// The disk of the recordings, and who hears of it.
#[derive(Clone)]
pub(super) struct Disk {
    storage: Storage,
    latest: Latest,
    board: Board,
    clock: WallClock,
    known: Arc<Mutex<Known>>,
    /// `None` where the folder could not be written at the start.
    taken: Arc<Mutex<Option<FolderLock>>>,
}

/// What was found before, and is reported when it changes.
#[derive(Default)]
struct Known {
    /// What the last cycle needed, where that did not fit into what may be used.
    short: Option<Need>,
    low: bool,
    doubt: Option<String>,
    /// Why the folder cannot be written.
    refused: Option<String>,
}

impl Disk {
    pub(super) fn new(
        storage: Storage,
        lock: Option<FolderLock>,
        latest: Latest,
        board: Board,
        clock: Arc<dyn Clock>,
    ) -> Self {
        let (taken, known) = (Arc::new(Mutex::new(lock)), Arc::default());
        Self { storage, latest, board, clock: WallClock::start(clock), known, taken }
    }

    /// [`Self::take_again`] where the disk may be slow.
    async fn looked_at_again(self) -> bool {
        tokio::task::spawn_blocking(move || self.take_again()).await.unwrap_or_else(|_| {
            error!("the folder was not locked; this is a defect of the program");
            false
        })
    }

    /// Takes the folder again that was removed, or could not be written. True, and logged, where whether it can be written has changed.
    fn take_again(&self) -> bool {
        let taken = self.take();
        let why = taken.as_ref().err().map(|refused| chain(refused));
        if std::mem::replace(&mut self.lock().refused, why.clone()) == why {
            return false;
        }
        match &taken {
            Ok(()) => {
                info!(
                    "the folder {} of the recordings can be written again",
                    self.storage.folder().display()
                );
            }
            Err(held @ LockError::Held { .. }) => error!("two services write there: {held}"),
            Err(refused @ LockError::Io { .. }) => warn!("{}", chain(refused)),
        }
        true
    }

    /// Tries whether the folder is ours and can be written.
    fn take(&self) -> Result<(), LockError> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = self.storage.folder();
        // The recorder makes a folder again that was removed.
        if taken.is_some() && !folder.is_dir() {
            return Ok(());
        }
        if !taken.as_ref().is_some_and(FolderLock::is_in_place) {
            *taken = Some(FolderLock::take(folder)?);
        }
        try_writing(folder)
    }

    /// Makes room for a cycle.
    ///
    /// # Errors
    /// There is none: why, for a person.
    pub(super) async fn make_room(&self, choice: &Choice) -> Result<(), String> {
        let visits = choice.plan.cycle.visits(&choice.plan.machine, &Pace::default());
        let cycle_s = visits.map_or(UNKNOWN_CYCLE_S, |visits| visits.duration_s);
        self.make_room_for(Need { readings_per_s: self.latest.readings_per_s(), cycle_s }).await
    }

    async fn make_room_for(&self, need: Need) -> Result<(), String> {
        let (storage, clock) = (self.storage.clone(), self.clock.clone());
        let made = tokio::task::spawn_blocking(move || storage.room(need, clock.today())).await;
        let room = match made {
            Ok(Ok((room, tidied))) => {
                self.report_tidied(tidied);
                room
            }
            // The recorder says what is wrong with the folder.
            Ok(Err(error)) => {
                warn!("the free space of the recordings is not known: {error}");
                return Ok(());
            }
            Err(_) => {
                error!("the free space was not looked at; this is a defect of the program");
                return Ok(());
            }
        };
        self.lock().short = (room != Room::Enough).then_some(need);
        self.report(&self.latest.recorder().unwrap_or_default()).await;
        match room {
            Room::TooLittle { .. } => Err(room.to_string()),
            Room::Enough | Room::Low { .. } => Ok(()),
        }
    }

    /// Publishes how the recorder and the disk are until `cancel`, and tidies the folder.
    pub(super) async fn watch(self, cancel: CancellationToken) {
        let mut period = tokio::time::interval(LOOK);
        let (mut looks, mut before, mut set_s) = (0_u32, RecorderStatus::default(), 0.0);
        loop {
            tokio::select! {
                () = cancel.cancelled() => return,
                _ = period.tick() => {}
            }
            let now = self.latest.recorder().unwrap_or_default();
            let is_refused = self.lock().refused.is_some();
            let fails = is_refused || now.failing.is_some() || self.board.hung().contains_key(RECORDER);
            let is_news = (&now.failing, now.lost_samples) != (&before.failing, before.lost_samples)
                || fails != self.is_shown_failing();
            let is_set = (self.clock.set_s() - set_s).abs() > WallClock::SET.as_secs_f64();
            let is_time = looks.is_multiple_of(TIDY_EVERY) && now.failing.is_none();
            let is_due = is_news || is_time || is_set;
            let is_other = (is_due || is_refused) && self.clone().looked_at_again().await;
            if is_due || is_other {
                before = now;
                self.tidy().await;
                self.report(&before).await;
            }
            if is_set {
                set_s = self.clock.set_s();
                report_set(set_s);
            }
            looks = looks.wrapping_add(1);
        }
    }

    /// True when `storage` says so; the watchdog publishes it too.
    fn is_shown_failing(&self) -> bool {
        let shown: Option<StorageNow> = topic(&self.board, StorageNow::TOPIC);
        shown.is_some_and(|shown| shown.state == StorageState::Failing)
    }

    async fn tidy(&self) {
        let (storage, clock) = (self.storage.clone(), self.clock.clone());
        match tokio::task::spawn_blocking(move || storage.tidy(clock.today())).await {
            Ok(Ok(tidied)) => self.report_tidied(tidied),
            Ok(Err(error)) => warn!("the folder of the recordings was not tidied: {error}"),
            Err(_) => error!("the folder was not tidied; this is a defect of the program"),
        }
    }

    /// Publishes the disk: as low while less is free than is to be kept, or than the last cycle would have needed, or nobody knows.
    async fn report(&self, recorder: &RecorderStatus) {
        let (storage, need) = (self.storage.clone(), self.lock().short.unwrap_or(Need::NOTHING));
        let look = move || (storage.free_mb(), storage.room_for(need), storage.runs());
        let Ok((free_mb, room, (runs, removed))) = tokio::task::spawn_blocking(look).await else {
            return error!("the disk was not looked at; this is a defect of the program");
        };
        let short = match room {
            Ok(Room::Enough) => None,
            Ok(short) => Some(short.to_string()),
            Err(error) => {
                let folder = self.storage.folder().display();
                Some(format!("the free space of {folder} cannot be read: {error}"))
            }
        };
        let hung = self.board.hung().remove(RECORDER).map(|why| format!("{RECORDER} hangs: {why}"));
        let refused = self.lock().refused.clone();
        let (state, why) = match (recorder.failing.clone().or(hung).or(refused), short) {
            (Some(failing), _) => (StorageState::Failing, Some(failing)),
            (None, Some(short)) => (StorageState::Low, Some(self.report_low(short))),
            (None, None) => (StorageState::Good, None),
        };
        if state == StorageState::Good {
            let mut known = self.lock();
            (known.short, known.low) = (None, false);
        }
        let free_mb = free_mb.ok().map(f64::round);
        let (lost_samples, not_removed) = (recorder.lost_samples, self.lock().doubt.clone());
        let now = StorageNow { state, reason: None, free_mb, why, lost_samples, runs, removed, not_removed };
        self.board.publish(&now);
    }

    /// Why it is low, with what keeps old recordings; logged when it begins.
    fn report_low(&self, room: String) -> String {
        let mut known = self.lock();
        let why = [Some(room), known.doubt.clone()].into_iter().flatten().collect::<Vec<_>>().join("; ");
        if !std::mem::replace(&mut known.low, true) {
            warn!("{why}");
        }
        why
    }

    fn report_tidied(&self, Tidied { removed, doubt }: Tidied) {
        for Removed { run, mb, why } in removed {
            self.board.publish(&SamplesRemoved { run, mb: mb.round(), why });
        }
        let mut known = self.lock();
        if let Some(why) = doubt.as_ref().filter(|why| known.doubt.as_ref() != Some(why)) {
            warn!("{why}");
        }
        known.doubt = doubt;
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The clock was set so far since the service began.
fn report_set(set_s: f64) {
    let (days, way) = (set_s.abs() / 86_400.0, if set_s < 0.0 { "back" } else { "forward" });
    match set_s == 0.0 {
        true => info!("the clock of the computer is again as it was when the service began"),
        false => warn!(
            "the clock of the computer was set {way} by {days:.2} days since the service began: dates of files and reports follow it, \
             ages of recordings and times of samples do not"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::SystemClock;
    use crate::storage::StorageConfig;

    fn disk(folder: &std::path::Path, keep_free_mb: f64) -> (Disk, Board) {
        let (board, clock): (_, Arc<dyn Clock>) = (Board::default(), Arc::new(SystemClock::start()));
        let config = StorageConfig { keep_free_mb, ..StorageConfig::default() };
        let latest = Latest::new(&[], Vec::new(), clock.clone());
        (Disk::new(Storage::new(folder, config, 3), None, latest, board.clone(), clock), board)
    }

    fn state(board: &Board) -> (StorageState, String) {
        let now: StorageNow = serde_json::from_value(board.get("storage").unwrap()).unwrap();
        (now.state, now.why.unwrap_or_default())
    }

    #[tokio::test]
    async fn a_disk_with_less_than_is_to_be_kept_free_is_low_at_every_look() {
        let folder = tempfile::tempdir().unwrap();
        let (disk, board) = disk(folder.path(), 1e9);
        disk.report(&RecorderStatus::default()).await;
        let (now, why) = state(&board);
        assert_eq!(now, StorageState::Low);
        assert!(why.contains("1000000000 are to be kept free"), "{why}");
        let failing = RecorderStatus { failing: Some("no space".into()), ..RecorderStatus::default() };
        disk.report(&failing).await;
        assert_eq!(state(&board), (StorageState::Failing, "no space".into()));
    }

    #[tokio::test]
    async fn a_folder_that_cannot_be_written_fails_until_it_can() {
        let root = tempfile::tempdir().unwrap();
        // A file where the folder should be refuses every user, root as well.
        let (place, folder) = (root.path().join("disk"), root.path().join("disk/runs"));
        std::fs::write(&place, "").unwrap();
        let (disk, board) = disk(&folder, 0.0);
        assert!(disk.take_again(), "that is news");
        assert!(!disk.take_again(), "it is none any more");
        disk.report(&RecorderStatus::default()).await;
        let (now, why) = state(&board);
        assert_eq!(now, StorageState::Failing);
        assert!(why.starts_with(&format!("cannot write into the folder {}", folder.display())), "{why}");
        std::fs::remove_file(&place).unwrap();
        assert!(disk.take_again(), "it can be written");
        disk.report(&RecorderStatus::default()).await;
        assert_eq!(state(&board), (StorageState::Good, String::new()));
        // The lock is in place, and nothing else can be written.
        let tried = folder.join(".trunnion.try");
        std::fs::create_dir(&tried).unwrap();
        assert!(disk.take_again());
        disk.report(&RecorderStatus::default()).await;
        assert_eq!(state(&board).0, StorageState::Failing);
    }

    #[tokio::test]
    async fn a_recorder_that_goes_on_is_shown_at_the_next_look_whoever_said_that_it_hung() {
        let folder = tempfile::tempdir().unwrap();
        let (disk, board) = disk(folder.path(), 0.0);
        let (cancel, mut changes) = (CancellationToken::new(), board.changes());
        let watching = tokio::spawn(disk.watch(cancel.clone()));
        for what in ["the first look", "one after the watchdog"] {
            // Less than TIDY_EVERY: then it is published anyway.
            tokio::time::timeout(LOOK * TIDY_EVERY / 2, changes.changed()).await.expect(what).unwrap();
            assert_eq!(state(&board).0, StorageState::Good, "{what}");
            board.publish(&StorageNow { state: StorageState::Failing, ..StorageNow::default() });
            changes.mark_unchanged();
        }
        cancel.cancel();
        watching.await.unwrap();
    }

    #[tokio::test]
    async fn runs_that_are_there_and_that_were_removed_are_counted_and_what_could_not_go_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in ["a", "b", "c"] {
            std::fs::write(place(&format!("{name}.mcap")), vec![0; 1_000_000]).unwrap();
            std::fs::write(place(&format!("{name}.diagnosis.json")), "{}").unwrap();
            let written =
                std::time::SystemTime::now() - Duration::from_secs(if name == "c" { 0 } else { 60 });
            std::fs::File::open(place(&format!("{name}.mcap"))).unwrap().set_modified(written).unwrap();
        }
        // A part of `a` that cannot be removed as a file is: it is a folder.
        std::fs::create_dir(place("a-2")).unwrap();
        let parts = trunnion::results::RunRecord {
            state: trunnion::results::RunState::Done,
            parts: vec!["a-2".into()],
            ..Default::default()
        };
        crate::run_record::write(&place("a.mcap"), &parts).unwrap();
        let config = StorageConfig { keep_free_mb: 0.0, budget_mb: Some(0.1), ..StorageConfig::default() };
        let (board, clock): (_, Arc<dyn Clock>) = (Board::default(), Arc::new(SystemClock::start()));
        let latest = Latest::new(&[], Vec::new(), clock.clone());
        let disk = Disk::new(Storage::new(folder.path(), config, 3), None, latest, board.clone(), clock);
        disk.tidy().await;
        disk.report(&RecorderStatus::default()).await;
        let now: StorageNow = serde_json::from_value(board.get("storage").unwrap()).unwrap();
        let why = now.not_removed.unwrap_or_default();
        assert!(why.starts_with("1 of 2 runs whose samples should go were removed"), "{why}");
        assert!(why.contains("a-2"), "{why}");
        assert_eq!((now.state, now.runs, now.removed), (StorageState::Good, 2, 1));
    }

    #[tokio::test]
    async fn a_disk_that_a_cycle_found_low_stays_low_until_there_is_room_for_it() {
        let folder = tempfile::tempdir().unwrap();
        let (disk, board) = disk(folder.path(), 0.0);
        let cycle_of = |mb: f64| Need { readings_per_s: mb * 1e6 / 40.0, cycle_s: 1.0 };
        let refused = disk.make_room_for(cycle_of(1e9)).await.unwrap_err();
        assert!(refused.contains("it would be cut"), "{refused}");
        // What is free changes with whatever else writes to the disk.
        let needed = |words: &str| words.split_once(" MB of the disk").map(|(_, rest)| rest.to_string());
        for _ in 0..2 {
            let (now, words) = state(&board);
            assert_eq!((now, needed(&words)), (StorageState::Low, needed(&refused)));
            assert!(needed(&words).is_some(), "{words}");
            disk.report(&RecorderStatus::default()).await;
        }
        assert_eq!(disk.make_room_for(cycle_of(0.0)).await, Ok(()));
        assert_eq!(state(&board), (StorageState::Good, String::new()));
    }
}
