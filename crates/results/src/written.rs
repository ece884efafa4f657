//! Recordings written from tables and by the simulator.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The answer of `import`: a recording made from a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Imported {
    /// Path of the recording.
    pub run: String,
    /// Points or samples taken.
    pub points: u64,
    /// Setups of the run.
    pub setups: usize,
    /// Name of the machine.
    pub machine: String,
}

/// `trunnion-simulation/1`: a recording made by the simulator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Simulation {
    /// Format and version.
    pub format: SimulationFormat,
    /// Points read.
    pub points: usize,
    /// Machine time, min.
    pub minutes: f64,
    /// Path of the recording.
    pub run: String,
}

/// Format and version of a simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SimulationFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-simulation/1")]
    V1,
}

/// `trunnion-scrubbed/1`: secrets left out of recordings that older versions made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Scrubbed {
    /// Format and version.
    pub format: ScrubbedFormat,
    /// Each recording asked for.
    pub recordings: Vec<ScrubbedRecording>,
}

/// What became of one recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScrubbedRecording {
    /// Path of the recording.
    pub run: String,
    /// True when it held secrets and was written again without them.
    pub changed: bool,
    /// What of it could not be read, and is not in the new file.
    pub damage: Option<String>,
}

/// Format and version of a list of scrubbed recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ScrubbedFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-scrubbed/1")]
    V1,
}

/// `trunnion-joined/1`: the recording of a cycle that was recorded in parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Joined {
    /// Format and version.
    pub format: JoinedFormat,
    /// Path of the recording.
    pub run: String,
    /// Readings in it.
    pub read: usize,
    /// Its parts, in order of time.
    pub parts: Vec<JoinedPart>,
}

/// One part of a cycle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JoinedPart {
    /// Name of its recording.
    pub run: String,
    /// When it begins, s since the cycle began.
    pub from_s: f64,
    /// When it ends, s since the cycle began.
    pub to_s: f64,
    /// Readings in it alone.
    pub read: usize,
}

/// Format and version of a joined recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum JoinedFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-joined/1")]
    V1,
}
