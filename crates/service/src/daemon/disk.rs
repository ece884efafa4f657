//! The disk while the service runs: room before a cycle, what is removed, and a recorder that cannot write, each said at once.

use crate::board::Board;
use crate::cycles::Choice;
use crate::latest::Latest;
use crate::storage::{Need, Removed, Room, Storage};
use serde_json::json;
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use tokio_util::sync::CancellationToken;
use tracing::{error, warn};
use trunnion::cycles::Pace;
use trunnion_core::Clock;

/// How often the recorder is looked at.
const LOOK: Duration = Duration::from_secs(1);
/// How often, in looks, the folder is tidied and the free space published.
const TIDY_EVERY: u32 = 60;
/// How long a cycle lasts of which the machine file does not say it, s: longer than any in `config/cycles`.
const UNKNOWN_CYCLE_S: f64 = 3600.0;

/// The disk of the recordings, and who hears of it.
#[derive(Clone)]
pub(super) struct Disk {
    pub(super) storage: Storage,
    pub(super) latest: Latest,
    pub(super) board: Board,
    pub(super) clock: Arc<dyn Clock>,
}

impl Disk {
    /// Makes room for a cycle.
    ///
    /// # Errors
    /// There is none: why, for a person.
    pub(super) async fn make_room(&self, choice: &Choice) -> Result<(), String> {
        let visits = choice.plan.cycle.visits(&choice.plan.machine, &Pace::default());
        let cycle_s = visits.map_or(UNKNOWN_CYCLE_S, |visits| visits.duration_s);
        let need = Need { readings_per_s: self.latest.readings_per_s(), cycle_s };
        let (storage, now) = (self.storage.clone(), self.now());
        let made = tokio::task::spawn_blocking(move || storage.room(need, now)).await;
        match made {
            Ok(Ok((room, removed))) => {
                self.tell_removed(removed);
                match room {
                    Room::Enough => {}
                    Room::Low { .. } => {
                        warn!("{room}");
                        self.board.set("storage", &json!({ "state": "low", "why": room.to_string() }));
                    }
                    Room::TooLittle { .. } => return Err(room.to_string()),
                }
            }
            // The recorder says what is wrong with the folder.
            Ok(Err(error)) => warn!("the free space of the recordings is not known: {error}"),
            Err(_) => warn!("the free space of the recordings is not known"),
        }
        Ok(())
    }

    /// Publishes how the recorder and the disk are until `cancel`, and tidies the folder.
    pub(super) async fn watch(self, cancel: CancellationToken) {
        let mut period = tokio::time::interval(LOOK);
        let (mut looks, mut failing, mut lost) = (0_u32, None, 0);
        loop {
            tokio::select! {
                () = cancel.cancelled() => return,
                _ = period.tick() => {}
            }
            let recorder = self.latest.recorder().unwrap_or_default();
            let is_news = (&recorder.failing, recorder.lost_samples) != (&failing, lost);
            if is_news || (looks.is_multiple_of(TIDY_EVERY) && failing.is_none()) {
                (failing, lost) = (recorder.failing, recorder.lost_samples);
                self.tell(failing.as_deref(), lost).await;
            }
            looks = looks.wrapping_add(1);
        }
    }

    async fn tell(&self, failing: Option<&str>, lost_samples: u64) {
        let (storage, now) = (self.storage.clone(), self.now());
        let looked = tokio::task::spawn_blocking(move || (storage.tidy(now), storage.free_mb())).await;
        let (tidied, free_mb) = match looked {
            Ok((tidied, free_mb)) => (tidied, free_mb.ok()),
            Err(_) => return error!("the disk was not looked at; this is a defect of the program"),
        };
        match tidied {
            Ok(removed) => self.tell_removed(removed),
            Err(error) => warn!("the folder of the recordings was not tidied: {error}"),
        }
        let state = if failing.is_some() { "failing" } else { "good" };
        let free_mb = free_mb.map(f64::round);
        let now = json!({ "state": state, "free_mb": free_mb, "why": failing, "lost_samples": lost_samples });
        self.board.set("storage", &now);
    }

    fn tell_removed(&self, removed: Vec<Removed>) {
        for Removed { run, mb, why } in removed {
            self.board.set("removed", &json!({ "run": run, "mb": mb.round(), "why": why }));
        }
    }

    fn now(&self) -> SystemTime {
        let ns = u64::try_from(self.clock.wall_ns()).unwrap_or(0);
        SystemTime::UNIX_EPOCH + Duration::from_nanos(ns)
    }
}
