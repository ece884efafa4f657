//! Where a recorded run is on its way to its report, and what came of it: the file `NAME.state.json` next to the recording.

use crate::{Complete, LocationErrors, TimeQuality, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-run/1`: state of a recorded run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunRecord {
    /// Format and version.
    pub format: RunRecordFormat,
    /// Where it is.
    pub state: RunState,
    /// When this was written, UTC.
    pub at: String,
    /// Name of its cycle; empty where it is not known.
    pub cycle: String,
    /// Further recordings of the same run, by file name: the disk was full in between.
    pub parts: Vec<String>,
    /// Recordings of the parts of the cycle that this one was joined from, by file name: the service ended in between.
    #[serde(default)]
    pub joined_from: Vec<String>,
    /// The recording that this one is a part of, by file name: what was found stands in its state. Null for a run of its own.
    #[serde(default)]
    pub joined_into: Option<String>,
    /// Analyses begun, those that failed and the present one.
    pub tries: u32,
    /// Why it failed or was not judged, or what came before this state; empty when there is nothing to say.
    pub why: String,
    /// What is missing from the recording, one sentence each.
    pub losses: Vec<String>,
    /// When and why its samples were removed; the report stays. Null while they are there.
    pub removed: Option<String>,
    /// What the analysis found; null before the first that succeeded.
    pub answer: Option<RunAnswer>,
}

/// Format and version of the state of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum RunRecordFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-run/1")]
    V1,
}

/// Where a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RunState {
    /// Its recording is finished.
    #[default]
    Recorded,
    /// The program ended while it was recorded; the recording was finished at the next start.
    Recovered,
    /// It is being analysed, or was when the program ended.
    Analysing,
    /// Its report is written.
    Done,
    /// Its report is written and holds no verdict: the run is not plausible or not whole, or the diagnosis failed.
    NotJudged,
    /// The last analysis failed, or the recording could not be finished.
    Failed,
    /// It is a part of another run, `joined_into`, which is analysed in its place.
    Joined,
}

impl RunState {
    /// Its name on every surface.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Recorded => "recorded",
            Self::Recovered => "recovered",
            Self::Analysing => "analysing",
            Self::Done => "done",
            Self::NotJudged => "not-judged",
            Self::Failed => "failed",
            Self::Joined => "joined",
        }
    }

    /// True when there is a report.
    pub fn has_report(self) -> bool {
        matches!(self, Self::Done | Self::NotJudged)
    }
}

/// What the analysis of a run found: the topics `result` and `quality`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunAnswer {
    /// For `result`.
    pub result: RunResult,
    /// For `quality`; null for a run without time stamps.
    pub quality: Option<TimeQuality>,
}

/// A report in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunResult {
    /// File name of the recording.
    pub run: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Why there is none, or no effect.
    pub why: String,
    /// What is planned, read, missing and excluded.
    pub complete: Complete,
    /// Ids of the effects that are missing, in the order in which a person would add them; the service adds none.
    pub missing_effects: Vec<String>,
    /// The location errors with u, of the model given; null for a run without a verdict. Those of a model in which an effect is missing
    /// contain part of it: see `verdict`.
    #[serde(default)]
    pub location_errors: Option<LocationErrors>,
    /// Residual of the model, µm rms.
    pub rms_um_before: f64,
    /// Residual with all of them, µm rms.
    pub rms_um_after: f64,
    /// Path of the page.
    pub report: String,
}
