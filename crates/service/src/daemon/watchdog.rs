//! The watchdog of systemd, tied to progress: it hears that the service lives while the recorder and the loop that takes the readings
//! go on.
//!
//! Both count turns: odd while they work, even while they wait for something to do. One that works at the same turn for [`HUNG`]
//! hangs, which `status` and `storage` then say. systemd then ends the service after `WatchdogSec` and starts it again; what was recorded is recovered.
//! A device that hangs is the supervisor's matter, an analysis that hangs is ended by its limits.

use super::status::notify_systemd;
use crate::board::Board;
use crate::latest::Latest;
use crate::plant::topic;
use std::sync::Arc;
use std::time::Duration;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use trunnion::results::{Published, StorageNow, StorageState};
use trunnion_core::{Clock, HostTime};

/// Time between two looks.
const LOOK: Duration = Duration::from_secs(1);
/// The kernel gives a disk so long for a command before it reports an error (`timeout` of a SCSI device in sysfs): what takes longer is
/// not slow.
const HUNG: Duration = Duration::from_secs(30);

/// The part that writes, on the board.
pub(super) const RECORDER: &str = "the recorder";

/// Pings systemd until `cancel`; whatever hangs withholds it, and is logged and published before.
pub async fn watch(latest: Latest, board: Board, clock: Arc<dyn Clock>, cancel: CancellationToken) {
    let mut period = tokio::time::interval(LOOK);
    let mut readings = Part::new("the loop that takes the readings", board.clone());
    let mut recorder = Part::new(RECORDER, board.clone());
    let mut ping: Option<JoinHandle<()>> = None;
    loop {
        tokio::select! {
            () = cancel.cancelled() => return,
            _ = period.tick() => {}
        }
        let now = clock.now();
        // The counter of the loop needs no lock that the loop may hold.
        if !readings.goes_on(latest.turn(), now) {
            continue;
        }
        let turn = latest.recorder().unwrap_or_default().turn;
        let recorder_goes_on = recorder.goes_on(turn, now);
        publish_hung(&board);
        // A systemd that does not take what it is sent gets no more of it.
        if recorder_goes_on && ping.as_ref().is_none_or(JoinHandle::is_finished) {
            ping = Some(notify_systemd(sd_notify::NotifyState::Watchdog));
        }
    }
}

/// Who looks at the disk may wait for it as the recorder does: `storage` says at once that nothing is written.
fn publish_hung(board: &Board) {
    let Some(why) = board.hung().remove(RECORDER) else { return };
    let now: StorageNow = topic(board, StorageNow::TOPIC).unwrap_or_default();
    if now.state != StorageState::Failing {
        let why = Some(format!("{RECORDER} hangs: {why}"));
        board.publish(&StorageNow { state: StorageState::Failing, why, ..now });
    }
}

/// A part of the service that counts its turns.
struct Part {
    name: &'static str,
    board: Board,
    turn: u64,
    since: Option<HostTime>,
    hangs: bool,
}

impl Part {
    fn new(name: &'static str, board: Board) -> Self {
        Self { name, board, turn: 0, since: None, hangs: false }
    }

    /// False while it hangs, which is logged and published when it begins and ends.
    fn goes_on(&mut self, turn: u64, now: HostTime) -> bool {
        let since = *self.since.get_or_insert(now);
        if turn != self.turn || turn.is_multiple_of(2) {
            (self.turn, self.since) = (turn, Some(now));
            if std::mem::take(&mut self.hangs) {
                tracing::warn!("{} goes on", self.name);
                self.board.set_hung(self.name, None);
            }
        } else if now - since >= HUNG && !std::mem::replace(&mut self.hangs, true) {
            let next = way_out(sd_notify::watchdog_enabled());
            let why = format!("it has done nothing for {} s; {next}", HUNG.as_secs());
            tracing::error!("{} hangs: {why}", self.name);
            self.board.set_hung(self.name, Some(why));
        }
        !self.hangs
    }
}

/// What becomes of a service that hangs, whose systemd waits for so long for a sign of it; `None` where nobody does.
fn way_out(watched: Option<Duration>) -> String {
    match watched {
        Some(after) => format!("systemd starts the service again in {} s", after.as_secs()),
        None => "start the service again, and check the disk of the recordings".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_hangs_that_works_at_one_turn_for_too_long() {
        let board = Board::default();
        let mut part = Part::new(RECORDER, board.clone());
        let at = |s: i64| HostTime(s * 1_000_000_000);
        assert!(part.goes_on(1, at(0)) && part.goes_on(1, at(29)));
        // It goes on, and works again.
        assert!(part.goes_on(3, at(30)) && part.goes_on(3, at(59)));
        assert!(!part.goes_on(3, at(60)) && !part.goes_on(3, at(61)));
        assert!(board.hung()[RECORDER].starts_with("it has done nothing for 30 s"), "{:?}", board.hung());
        publish_hung(&board);
        let said: StorageNow = topic(&board, "storage").unwrap();
        assert_eq!(said.state, StorageState::Failing);
        assert!(
            said.why.as_ref().unwrap().starts_with("the recorder hangs: it has done nothing for 30 s"),
            "{said:?}"
        );
        assert!(part.goes_on(5, at(62)));
        assert!(board.hung().is_empty(), "it goes on");
        // It may wait for ever.
        assert!(part.goes_on(6, at(63)) && part.goes_on(6, at(10_000)));
        assert!(part.goes_on(7, at(10_001)) && !part.goes_on(7, at(10_031)));
    }

    #[test]
    fn only_a_systemd_that_watches_is_announced() {
        assert_eq!(way_out(Some(Duration::from_secs(30))), "systemd starts the service again in 30 s");
        assert_eq!(way_out(None), "start the service again, and check the disk of the recordings");
    }
}
