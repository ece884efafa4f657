//! How the service does: the worst of devices, recorder, disk, analysis, its own parts, and of broker, page and servers where there are any.

use crate::board::Board;
use std::collections::BTreeMap;
use tokio::sync::watch;
use trunnion::results::{Condition, Health, PartHealth};
use trunnion_acquire::{DeviceState, DeviceStatus};

/// From the states of the devices, by name, and what the others said on the board.
pub(super) fn health<'a>(
    devices: impl Iterator<Item = (&'a String, &'a watch::Receiver<DeviceStatus>)>,
    board: &Board,
) -> Health {
    let mut parts = BTreeMap::from([
        ("devices".to_owned(), of_devices(devices)),
        ("recorder".to_owned(), of_topic(board, "storage", &[("failing", Condition::Failing)])),
        (
            "disk".to_owned(),
            of_topic(board, "storage", &[("failing", Condition::Failing), ("low", Condition::Limited)]),
        ),
        ("analysis".to_owned(), of_topic(board, "result", &[("failed", Condition::Limited)])),
        ("service".to_owned(), of_hung(board)),
    ]);
    // Measuring goes on without them.
    for (name, why) in board.connections() {
        let state = if why.is_empty() { Condition::Good } else { Condition::Limited };
        parts.insert(name.into(), PartHealth { state, why });
    }
    Health::of(parts)
}

/// The worst of them, with the words of each that is no better.
fn of_devices<'a>(
    devices: impl Iterator<Item = (&'a String, &'a watch::Receiver<DeviceStatus>)>,
) -> PartHealth {
    let devices: Vec<(Condition, String)> = devices
        .map(|(name, status)| {
            let status = status.borrow();
            let end = status.last_end.as_ref().map_or_else(String::new, |end| format!(": {end}"));
            (condition(status.state), format!("{name} is {:?}{end}", status.state))
        })
        .collect();
    let worst = devices.iter().map(|(state, _)| *state).max().unwrap_or_default();
    let words = devices.into_iter().filter(|(state, _)| *state != Condition::Good).map(|(_, words)| words);
    PartHealth::new(worst, words.collect::<Vec<_>>().join("; "))
}

/// What a person must mend is failing; what may come by itself is limited.
fn condition(state: DeviceState) -> Condition {
    match state {
        DeviceState::Streaming => Condition::Good,
        DeviceState::Absent
        | DeviceState::Connecting
        | DeviceState::Stuck
        | DeviceState::Silent
        | DeviceState::Failed
        | DeviceState::Stopped => Condition::Limited,
        DeviceState::WrongDevice | DeviceState::Refused => Condition::Failing,
    }
}

/// A part that is bad when its topic says one of these states.
fn of_topic(board: &Board, topic: &str, bad: &[(&str, Condition)]) -> PartHealth {
    let now = board.get(topic).unwrap_or_default();
    let how = bad.iter().find(|(state, _)| now["state"] == *state);
    how.map_or_else(PartHealth::default, |&(_, how)| {
        PartHealth::new(how, now["why"].as_str().unwrap_or_default())
    })
}

/// Parts of the service itself: one that hangs does not do its work.
fn of_hung(board: &Board) -> PartHealth {
    let hung: Vec<String> =
        board.hung().into_iter().map(|(part, why)| format!("{part} hangs: {why}")).collect();
    match hung.is_empty() {
        true => PartHealth::default(),
        false => PartHealth::new(Condition::Failing, hung.join("; ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_service_is_as_good_as_its_worst_part() {
        let (board, name) = (Board::default(), "probe-1".to_owned());
        let (send, state) = watch::channel(DeviceStatus::default());
        let of = |board: &Board| health([(&name, &state)].into_iter(), board);
        assert_eq!(of(&board).state, Condition::Limited);
        assert_eq!(of(&board).parts["devices"].why, "probe-1 is Absent");

        send.send_modify(|status| status.state = DeviceState::Streaming);
        assert_eq!(of(&board).state, Condition::Good);
        assert!(!of(&board).parts.contains_key("broker"), "there is none");

        board.set_connection("opcua", "");
        board.set_connection("mtconnect", "127.0.0.1:7878 cannot be listened on");
        assert_eq!(of(&board).parts["opcua"].state, Condition::Good);
        assert_eq!(of(&board).parts["mtconnect"].why, "127.0.0.1:7878 cannot be listened on");
        assert_eq!(of(&board).state, Condition::Limited);
        board.set_connection("mtconnect", "");

        board.set("result", &json!({ "state": "failed", "why": "out of memory" }));
        assert_eq!(of(&board).parts["analysis"], PartHealth::new(Condition::Limited, "out of memory"));
        board.set("storage", &json!({ "state": "failing", "why": "no space is left" }));
        assert_eq!(of(&board).state, Condition::Failing);
        for part in ["recorder", "disk"] {
            assert_eq!(of(&board).parts[part].why, "no space is left");
        }

        board.set("storage", &json!({ "state": "good" }));
        board.set_hung("the recorder", Some("it has done nothing for 30 s".into()));
        assert_eq!(of(&board).state, Condition::Failing);
        assert_eq!(of(&board).parts["service"].why, "the recorder hangs: it has done nothing for 30 s");
        board.set_hung("the recorder", None);
        assert_eq!(of(&board).parts["service"], PartHealth::default());

        send.send_modify(|status| status.state = DeviceState::WrongDevice);
        assert_eq!(of(&board).parts["devices"].state, Condition::Failing);
    }
}
