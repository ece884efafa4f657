//! What the service publishes of cycles: where the newest one is, whether one may begin, and what came of a run.

use crate::run_record::RunResult;
use crate::service_status::{CycleState, Presence};
use crate::topics::Published;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The topic `cycle`: the newest cycle. What was not said of it yet is absent, but for the time left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct CycleProgress {
    /// Where it is.
    pub state: CycleState,
    /// Why it is offline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Name of its run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<String>,
    /// Before the first: names of the cycles that the service can measure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycles: Option<Vec<String>>,
    /// Before the first: what it begins with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waits_for: Option<String>,
    /// Name of the cycle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<String>,
    /// The program that the controller showed; empty when it showed none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// By what it began; why it was refused or failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Points that are over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub done: Option<usize>,
    /// Points of the cycle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<usize>,
    /// Time left, s; null while it is not known, and when the cycle is over.
    pub seconds_left: Option<f64>,
    /// File name of its recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// How it ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<String>,
    /// Points read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub read: Option<u64>,
    /// Points without a reading that settled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unsettled: Option<u64>,
    /// Points that were not stood at, or without a value of every probe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missing: Option<u64>,
    /// Gaps of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gaps: Option<usize>,
}

impl CycleProgress {
    /// With what is said now; what was said before stays, but for the time left, which was that of before.
    #[must_use]
    pub fn updated(self, now: Self) -> Self {
        Self {
            state: now.state,
            reason: now.reason.or(self.reason),
            run: now.run.or(self.run),
            cycles: now.cycles.or(self.cycles),
            waits_for: now.waits_for.or(self.waits_for),
            cycle: now.cycle.or(self.cycle),
            program: now.program.or(self.program),
            why: now.why.or(self.why),
            done: now.done.or(self.done),
            total: now.total.or(self.total),
            seconds_left: now.seconds_left,
            recording: now.recording.or(self.recording),
            ended: now.ended.or(self.ended),
            read: now.read.or(self.read),
            unsettled: now.unsettled.or(self.unsettled),
            missing: now.missing.or(self.missing),
            gaps: now.gaps.or(self.gaps),
        }
    }
}

impl Published for CycleProgress {
    const TOPIC: &'static str = "cycle";
}

/// The topic `ready`: whether a cycle may begin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ReadyNow {
    /// `offline` when the service does not run; absent while it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<Presence>,
    /// Why it is offline.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// True when nothing stands against it.
    pub ready: bool,
    /// What stands against it, each with what to do.
    pub why: Vec<String>,
}

impl Published for ReadyNow {
    const TOPIC: &'static str = "ready";
}

/// The topic `result`: what came of the run that was analysed last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ResultNow {
    /// It has no report.
    Failed(RunFailed),
    /// Its report in short.
    Found(Box<RunResult>),
}

impl Published for ResultNow {
    const TOPIC: &'static str = "result";
}

/// A run without a report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunFailed {
    /// Says that this is no report.
    pub state: FailedState,
    /// Name of the run.
    pub run: String,
    /// Why.
    pub why: String,
}

/// `failed`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FailedState {
    /// It could not be analysed.
    #[default]
    Failed,
}

/// The topic `model`: the effect that a person added or removed last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModelChanged {
    /// Name of the run.
    pub run: String,
    /// Id of the effect.
    pub effect: String,
    /// What was done with it.
    pub state: ModelStep,
    /// When, in the time of the service, ns: no two steps have the same.
    pub at_ns: i64,
}

impl Published for ModelChanged {
    const TOPIC: &'static str = "model";
    const SCHEMA: &'static str = "model-changed";
}

/// What was done with an effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ModelStep {
    /// It is in the model.
    #[default]
    Added,
    /// It is not any more.
    Removed,
}
