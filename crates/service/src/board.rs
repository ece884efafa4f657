//! What the service says of itself: the present value of every topic, for the page and the broker.

use crate::clock::{SystemClock, moment};
use crate::operator::Operator;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::watch;
use trunnion::results::{OF_THE_PRESENT, Offline, OfflineReason, OfflineState, Published};
use trunnion_core::Clock;

/// Latest value of each topic, shared with who shows them.
#[derive(Clone, Default)]
pub struct Board {
    shared: Arc<Shared>,
}

#[derive(Default)]
struct Shared {
    topics: Mutex<BTreeMap<String, Topic>>,
    operator: Operator,
    /// Counts the changes.
    changes: watch::Sender<u64>,
    /// Connections and ports of the configuration, each with why it does not work; empty when it does.
    connections: Mutex<BTreeMap<&'static str, String>>,
    /// Parts of the service that hang, each with what happens next.
    hung: Mutex<BTreeMap<&'static str, String>>,
}

/// The value of a topic.
#[derive(Clone)]
pub(crate) struct Topic {
    payload: String,
    /// What MQTT gets: the same with time and version.
    pub stamped: String,
    /// The broker has it.
    pub sent: bool,
}

impl Board {
    /// Sets the value of a topic below `trunnion/<machine>/`. Never waits; an unsent older value is replaced.
    pub fn set(&self, topic: &str, value: &serde_json::Value) {
        let topic_value = Topic { payload: value.to_string(), stamped: stamped(value), sent: false };
        self.lock().insert(topic.into(), topic_value);
        self.shared.changes.send_modify(|changes| *changes += 1);
    }

    /// Sets the value of a topic whose form is known.
    pub fn publish<T: Published>(&self, value: &T) {
        match serde_json::to_value(value) {
            Ok(value) => self.set(T::TOPIC, &value),
            Err(failure) => tracing::error!(%failure, "the topic {} is no JSON", T::TOPIC),
        }
    }

    /// The present value of every topic, as text.
    pub fn now(&self) -> BTreeMap<String, String> {
        self.lock().iter().map(|(name, topic)| (name.clone(), topic.payload.clone())).collect()
    }

    /// Changes when a topic changes; several changes at once may be seen as one.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.shared.changes.subscribe()
    }

    /// The present value of a topic, as JSON.
    pub fn get(&self, topic: &str) -> Option<serde_json::Value> {
        serde_json::from_str(&self.lock().get(topic)?.payload).ok()
    }

    /// Broker, page and servers of the configuration, each with why it does not work: empty when it does.
    pub fn connections(&self) -> BTreeMap<&'static str, String> {
        self.shared.connections.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Empty: it works.
    pub(crate) fn set_connection(&self, name: &'static str, why: &str) {
        self.shared.connections.lock().unwrap_or_else(PoisonError::into_inner).insert(name, why.into());
    }

    /// Parts of the service that hang, each with what happens next.
    pub(crate) fn hung(&self) -> BTreeMap<&'static str, String> {
        self.shared.hung.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// `None`: it goes on.
    pub(crate) fn set_hung(&self, part: &'static str, why: Option<String>) {
        let mut hung = self.shared.hung.lock().unwrap_or_else(PoisonError::into_inner);
        match why {
            Some(why) => hung.insert(part, why),
            None => hung.remove(part),
        };
    }

    /// Who chooses, begins and ends cycles.
    pub fn operator(&self) -> &Operator {
        &self.shared.operator
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Topic>> {
        self.shared.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The last words: what was not sent yet, and that there is no present any more.
    pub(crate) fn farewell(&self) -> Vec<(String, String)> {
        let gone = |name: &String| OF_THE_PRESENT.contains(&name.as_str());
        let stopped = offline(OfflineReason::Stopped);
        let topics = self.lock();
        let words = topics.iter().filter(|(name, topic)| gone(name) || !topic.sent);
        words
            .map(|(name, topic)| {
                (name.clone(), if gone(name) { stopped.clone() } else { topic.stamped.clone() })
            })
            .collect()
    }

    /// The broker has nothing of it any more.
    pub(crate) fn forget_what_was_sent(&self) {
        self.lock().values_mut().for_each(|topic| topic.sent = false);
    }
}

/// A topic of a service that is not there, of the time at which this is said.
pub(crate) fn offline(reason: OfflineReason) -> String {
    let (time, version) = stamp();
    serde_json::json!(Offline { state: OfflineState::Offline, reason, time, version }).to_string()
}

/// With time and version.
fn stamped(value: &serde_json::Value) -> String {
    let mut value = value.clone();
    if let serde_json::Value::Object(fields) = &mut value {
        let (time, version) = stamp();
        fields.insert("time".into(), time.into());
        fields.insert("version".into(), version.into());
    }
    value.to_string()
}

/// The time (UTC) and the version of the program.
fn stamp() -> (String, String) {
    (moment(SystemClock::start().wall_ns()), env!("CARGO_PKG_VERSION").into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_of_the_present_is_offline_in_the_end_and_what_was_found_stays() {
        let board = Board::default();
        for topic in OF_THE_PRESENT {
            board.set(topic, &json!({ "state": "good" }));
        }
        board.set("result", &json!({ "run": "a" }));
        let words: BTreeMap<String, String> = board.farewell().into_iter().collect();
        for topic in OF_THE_PRESENT {
            let said: Offline = serde_json::from_str(&words[topic]).unwrap();
            assert_eq!(said.reason, OfflineReason::Stopped, "{topic}");
        }
        assert!(words["result"].contains("\"run\":\"a\""), "{}", words["result"]);
    }
}
