//! What the service reports of itself: the board's `status` and systemd.

use super::states::States;
use crate::latest::{Latest, Readiness};
use crate::mqtt::Board;
use serde_json::json;
use std::time::Duration;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use trunnion_acquire::DeviceStatus;

/// Time between status messages.
const STATUS_PERIOD: Duration = Duration::from_secs(1);

/// Publishes the states of devices and cycles when they change, and reports to systemd that the service is alive.
pub async fn publish_status(
    names: Vec<String>,
    states: Vec<watch::Receiver<DeviceStatus>>,
    board: Board,
    cycles: States,
    cancel: CancellationToken,
) {
    let mut period = tokio::time::interval(STATUS_PERIOD);
    let mut last = serde_json::Value::Null;
    loop {
        tokio::select! {
            () = cancel.cancelled() => return,
            _ = period.tick() => {}
        }
        report_systemd(&[sd_notify::NotifyState::Watchdog]);
        let devices: serde_json::Map<String, serde_json::Value> = names
            .iter()
            .zip(&states)
            .map(|(name, state)| {
                let status = state.borrow();
                let ends: u64 = status.ends.iter().sum();
                let device = json!({ "state": format!("{:?}", status.state), "identity": status.identity,
                    "connections": status.epoch, "ends": ends, "lost_messages": status.lost_messages,
                    "last_end": status.last_end.as_ref().map(ToString::to_string) });
                (name.clone(), device)
            })
            .collect();
        let now = json!({ "state": "online", "devices": devices, "cycle": cycles.now(), "chosen": board.peek_chosen() });
        if now != last {
            board.set("status", &now);
            last = now;
        }
    }
}

/// Publishes the latest values once a second, and whether a cycle may begin when that changes; the board keeps the newest alone,
/// however slow the broker is.
pub(super) async fn publish_live(latest: Latest, needed: Vec<u16>, board: Board, cancel: CancellationToken) {
    let mut readiness = Readiness::default();
    let mut period = tokio::time::interval(STATUS_PERIOD);
    loop {
        tokio::select! {
            () = cancel.cancelled() => return,
            _ = period.tick() => {}
        }
        if let Some(why) = readiness.changed(latest.before_a_cycle(&needed)) {
            match why.is_empty() {
                true => tracing::info!("every channel of the cycle reads and is at its centre"),
                false => why.iter().for_each(|why| tracing::warn!("not ready for a cycle: {why}")),
            }
            let words: Vec<String> = why.iter().map(ToString::to_string).collect();
            board.set("ready", &json!({ "ready": words.is_empty(), "why": words }));
        }
        match serde_json::to_value(latest.snapshot()) {
            Ok(live) => board.set("live", &live),
            Err(failure) => tracing::debug!(%failure, "the latest values are no JSON"),
        }
    }
}

/// Notifies systemd, where there is one.
pub(super) fn report_systemd(states: &[sd_notify::NotifyState<'_>]) {
    if let Err(failure) = sd_notify::notify(states) {
        tracing::debug!(%failure, "systemd was not reported");
    }
}
