//! What the service publishes of itself: the topic `status`.

use crate::topics::Published;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The topic `status`. Over MQTT every topic also has `time` (UTC, when it was set) and `version` (of the program).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ServiceStatus {
    /// Whether the service runs. `offline` is what the broker says for a service that stopped or was lost.
    pub state: Presence,
    /// Why it is offline: `stopped`, or `lost` when the broker says it; null while it runs.
    pub reason: Option<String>,
    /// The worst of its parts; null while offline.
    pub health: Option<Health>,
    /// Every device by its name.
    pub devices: BTreeMap<String, DeviceNow>,
    /// The newest cycle; null while offline.
    pub cycle: Option<CycleNow>,
    /// The cycle that the operator chose for the next start.
    pub chosen: Option<String>,
    /// The last choice over MQTT where it was not taken; null otherwise.
    pub choice_refused: Option<ChoiceRefused>,
}

/// A choice of a cycle that was not taken.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ChoiceRefused {
    /// Why, with the names that are allowed.
    pub why: String,
    /// How often the same was refused, one after the other.
    pub times: u64,
}

impl Published for ServiceStatus {
    const TOPIC: &'static str = "status";
}

/// Whether the service runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Presence {
    /// It does not.
    #[default]
    Offline,
    /// It does.
    Online,
}

/// How a part does, the worse the larger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Condition {
    /// As it should.
    #[default]
    Good,
    /// It does its work, or waits for what comes by itself; somebody should look when there is time.
    Limited,
    /// It does not do its work.
    Failing,
}

impl Condition {
    /// Its name on every surface.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Limited => "limited",
            Self::Failing => "failing",
        }
    }
}

/// How the service does: the worst of its parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Health {
    /// The worst.
    pub state: Condition,
    /// `devices`, `recorder`, `disk`, `analysis`, `service` (a part of it that hangs); `broker`, `sparkplug`, `page`, `mtconnect` and `opcua` where the configuration has them.
    pub parts: BTreeMap<String, PartHealth>,
}

/// How a part of the service does.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PartHealth {
    /// How it does.
    pub state: Condition,
    /// Why, for a person; empty when it is good.
    pub why: String,
}

impl PartHealth {
    /// A part with why it is no better.
    pub fn new(state: Condition, why: impl Into<String>) -> Self {
        Self { state, why: why.into() }
    }
}

impl Health {
    /// Of these parts.
    pub fn of(parts: BTreeMap<String, PartHealth>) -> Self {
        Self { state: parts.values().map(|part| part.state).max().unwrap_or_default(), parts }
    }
}

/// A device now.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DeviceNow {
    /// `Streaming` when readings arrive; every other state and its remedy are in docs/measured/faults.md.
    pub state: String,
    /// What it said of itself; empty until it is identified.
    pub identity: String,
    /// Connections begun.
    pub connections: u32,
    /// Sessions that ended.
    pub ends: u64,
    /// Messages that were not taken in time.
    pub lost_messages: u64,
    /// Why the last session ended.
    pub last_end: Option<String>,
}

/// The newest cycle, in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CycleNow {
    /// Where it is.
    pub state: CycleState,
    /// Name of its run; null without one.
    pub run: Option<String>,
}

/// Where the newest cycle is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CycleState {
    /// The service does not run.
    Offline,
    /// The service waits for the first.
    #[default]
    Ready,
    /// A program runs for which there is no cycle.
    Refused,
    /// A cycle runs.
    Measuring,
    /// It is over; its recording is analysed.
    Analysing,
    /// Its report is written.
    Done,
    /// It could not be measured or analysed.
    Failed,
}

impl CycleState {
    /// Its name on every surface.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Offline => "offline",
            Self::Ready => "ready",
            Self::Refused => "refused",
            Self::Measuring => "measuring",
            Self::Analysing => "analysing",
            Self::Done => "done",
            Self::Failed => "failed",
        }
    }
}
