//! Topics of the present, and what they say while no service runs.

use crate::cycle_topics::{CycleProgress, ReadyNow};
use crate::live::Live;
use crate::service_status::ServiceStatus;
use crate::set_up_state::SetUpState;
use crate::topics::{Published, StorageNow};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Topics of the present, which a service that does not run has not: they are [`Offline`] then.
pub const OF_THE_PRESENT: [&str; 6] = [
    ServiceStatus::TOPIC,
    CycleProgress::TOPIC,
    Live::TOPIC,
    ReadyNow::TOPIC,
    StorageNow::TOPIC,
    SetUpState::TOPIC,
];

/// A topic of the present over MQTT.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum OrOffline<T> {
    /// The service does not run.
    Offline(Offline),
    /// It runs.
    Now(T),
}

/// What the broker says of a topic of the present while the service does not run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Offline {
    /// Says that this is all.
    pub state: OfflineState,
    /// Why.
    pub reason: OfflineReason,
    /// `stopped`: when the service stopped. `lost`: when it connected to the broker, which got its last will then; when it was lost, nobody says. UTC.
    pub time: String,
    /// Of the program that ran.
    pub version: String,
}

/// `offline`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OfflineState {
    /// The service does not run.
    #[default]
    Offline,
}

/// Why a service does not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OfflineReason {
    /// It was stopped.
    Stopped,
    /// The broker heard nothing more of it: its last will, of the topic `status` alone.
    Lost,
}
