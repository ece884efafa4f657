//! What the service reports of itself: the board's `status` and systemd.

use super::health::health;
use super::states::States;
use crate::board::Board;
use crate::latest::{Latest, NotReady, Readiness};
use crate::plant::topic;
use sd_notify::NotifyState;
use std::collections::BTreeMap;
use std::time::Duration;
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use trunnion::results::{
    DeviceNow, Presence, Published, ReadyNow, ServiceStatus, StorageNow, StorageState, Zone,
};
use trunnion_acquire::DeviceStatus;

/// Time between status messages.
const STATUS_PERIOD: Duration = Duration::from_secs(1);

/// Publishes the states of devices and cycles when they change.
pub async fn publish_status(
    names: Vec<String>,
    states: Vec<watch::Receiver<DeviceStatus>>,
    board: Board,
    cycles: States,
    cancel: CancellationToken,
) {
    let mut period = tokio::time::interval(STATUS_PERIOD);
    let mut last = None;
    loop {
        tokio::select! {
            () = cancel.cancelled() => return,
            _ = period.tick() => {}
        }
        let devices: BTreeMap<String, DeviceNow> =
            names.iter().zip(&states).map(|(name, state)| (name.clone(), now(&state.borrow()))).collect();
        let status = ServiceStatus {
            state: Presence::Online,
            reason: None,
            health: Some(health(names.iter().zip(&states), &board)),
            devices,
            cycle: Some(cycles.now()),
            chosen: board.operator().peek_chosen(),
            choice_refused: board.operator().refused(),
        };
        if last.as_ref() == Some(&status) {
            continue;
        }
        board.publish(&status);
        last = Some(status);
    }
}

fn now(status: &DeviceStatus) -> DeviceNow {
    DeviceNow {
        state: format!("{:?}", status.state),
        identity: status.identity.clone(),
        connections: status.epoch,
        ends: status.ends.iter().sum(),
        lost_messages: status.lost_messages,
        last_end: status.last_end.as_ref().map(ToString::to_string),
    }
}

/// Publishes the latest values once a second, and whether a cycle may begin when that changes; the board keeps the newest alone,
/// however slow the broker is.
pub async fn publish_live(latest: Latest, needed: Vec<u16>, board: Board, cancel: CancellationToken) {
    let mut readiness = Readiness::default();
    let mut period = tokio::time::interval(STATUS_PERIOD);
    loop {
        tokio::select! {
            () = cancel.cancelled() => return,
            _ = period.tick() => {}
        }
        let before = latest.before_a_cycle(&needed).map(|devices| [devices, not_written(&board)].concat());
        if let Some(why) = readiness.changed(before) {
            match why.is_empty() {
                true => tracing::info!("every channel of the cycle reads and is at its centre"),
                false => why.iter().for_each(|why| tracing::warn!("not ready for a cycle: {why}")),
            }
            let words: Vec<String> = why.iter().map(ToString::to_string).collect();
            board.publish(&ReadyNow { ready: words.is_empty(), why: words, ..ReadyNow::default() });
        }
        board.publish(&latest.snapshot());
    }
}

/// A cycle that cannot be written stands against the next one.
fn not_written(board: &Board) -> Vec<NotReady> {
    let storage: StorageNow = topic(board, StorageNow::TOPIC).unwrap_or_default();
    let why = storage.why.filter(|_| storage.state == StorageState::Failing);
    why.map(|why| NotReady { source: "recordings".into(), zone: Zone::NoValue, why }).into_iter().collect()
}

/// Notifies systemd, where there is one; one that does not take it holds a thread of its own.
pub(super) fn notify_systemd(state: NotifyState<'static>) -> JoinHandle<()> {
    tokio::task::spawn_blocking(move || match (sd_notify::notify(std::slice::from_ref(&state)), state) {
        (Ok(()), _) => {}
        // Without it systemd ends the service after its start-up time.
        (Err(failure), NotifyState::Ready) => tracing::warn!(%failure, "systemd was not notified"),
        (Err(failure), _) => tracing::debug!(%failure, "systemd was not notified"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_that_cannot_be_written_stand_against_a_cycle() {
        let board = Board::default();
        assert_eq!(not_written(&board), []);
        let storage = |state| StorageNow { state, why: Some("read-only".into()), ..StorageNow::default() };
        board.publish(&storage(StorageState::Low));
        assert_eq!(not_written(&board), [], "it is recorded");
        board.publish(&storage(StorageState::Failing));
        assert_eq!(not_written(&board)[0].to_string(), "recordings: read-only");
    }
}
