//! The runs of one machine in order of time: what was found, control limits, what changed.

use crate::change::ChangedParameter;
use crate::corrected::{AroundCorrection, CorrectionEntered};
use crate::diagnosis::Verdict;
use crate::forecast::DayForecast;
use crate::identification::Parameter;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-history/1`: the runs of one machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MachineHistory {
    /// Format and version.
    pub format: HistoryFormat,
    /// Name of the machine.
    pub machine: String,
    /// Ids of the effects of the model that every run was fitted with.
    pub effects: Vec<String>,
    /// The runs, oldest first.
    pub runs: Vec<HistoryRun>,
    /// The values that are watched, each with its limits.
    pub watched: Vec<Watched>,
    /// What changed from the last run but one to the last; null where there are no two, and where they cannot be compared.
    pub change: Option<RunChange>,
    /// Why the last two cannot be compared; empty otherwise.
    #[serde(default)]
    pub why_no_change: String,
    /// Corrections that were entered into the control, oldest first; control limits begin again after each.
    #[serde(default)]
    pub corrections: Vec<CorrectionEntered>,
    /// The runs before and after each correction, the latest first.
    #[serde(default)]
    pub around_corrections: Vec<AroundCorrection>,
    /// What the next day is expected to show; null where it was not asked for: it takes fits of all runs together.
    #[serde(default)]
    pub forecast: Option<DayForecast>,
    /// What a person should know of the list, one sentence each.
    pub notes: Vec<String>,
}

/// Format and version of a history.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum HistoryFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-history/1")]
    V1,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HistoryRun {
    /// Name of the run.
    pub run: String,
    /// When it began, s since 1970 UTC; null where the recording does not say.
    pub began_s: Option<i64>,
    /// The same for a person; empty where it is not known.
    pub began: String,
    /// What the diagnosis says.
    pub verdict: Verdict,
    /// The effects found together, else the effect or expression that leads, if the verdict names one.
    pub candidate: Option<String>,
    /// Residual of the fit, µm rms; null where the run was not fitted.
    pub rms_um: Option<f64>,
    /// Mean of the temperatures, °C; null without any.
    pub temperature_degc: Option<f64>,
    /// Parameters of the machine that have a number.
    pub values: Vec<Parameter>,
    /// Names of the watched values that lie outside their limits.
    pub alarms: Vec<String>,
    /// Why the run cannot be compared; empty otherwise.
    pub trouble: String,
    /// What is missing from its recordings, one sentence each; empty where the history is of kept answers: the state of each run has it.
    #[serde(default)]
    pub losses: Vec<String>,
}

/// A value that is watched over the runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Watched {
    /// Name of the parameter, with its effect where parameters of several have that name (`scale of linear-scale:Z`); or `rms`.
    pub name: String,
    /// Id of its effect; empty for the residual.
    #[serde(default)]
    pub effect: String,
    /// What it is, for a person; the name where there are no words for it.
    #[serde(default)]
    pub words: String,
    /// Its unit.
    pub unit: String,
    /// Its value in every run that has one, with the limits that held then.
    pub points: Vec<WatchedPoint>,
}

impl Watched {
    /// Name of the residual among the watched values.
    pub const RESIDUAL: &str = "rms";

    /// `direction of axis B about X (EA0B)`; the residual has no symbol.
    pub fn title(&self) -> String {
        match self.name.as_str() {
            name if self.words == name || self.words.is_empty() => name.into(),
            Self::RESIDUAL => self.words.clone(),
            name => format!("{} ({name})", self.words),
        }
    }
}

/// A watched value in one run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WatchedPoint {
    /// Index of the run.
    pub run: usize,
    /// The value.
    pub value: f64,
    /// Its standard uncertainty; 0 where it has none.
    pub u: f64,
    /// Mean of the runs before, and the limits they set; null before the third run.
    pub limits: Option<[f64; 3]>,
    /// How many runs set these limits.
    #[serde(default)]
    pub set_by: usize,
    /// True when it lies outside.
    pub alarm: bool,
}

impl WatchedPoint {
    /// Limits that fewer runs set are more than twice as far apart as those of many: t(p; ν) > 2 t(p; ∞) for ν ≤ 6 at p = 1/3650, ten
    /// watched values (`trunnion_methods::control_chart`).
    pub const FEW_RUNS: usize = 8;

    /// True where its limits let large changes pass, because few runs set them.
    pub fn has_wide_limits(&self) -> bool {
        self.limits.is_some() && self.set_by < Self::FEW_RUNS
    }
}

/// What changed between two runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunChange {
    /// The earlier run.
    pub from: String,
    /// The later run.
    pub to: String,
    /// Ids of effects that the later run shows and the earlier does not.
    pub new_effects: Vec<String>,
    /// Every parameter of the machine that both runs determine, most changed first.
    pub parameters: Vec<ChangedParameter>,
    /// Error of the values of the earlier run in the later one, µm rms; null where they cannot be used.
    pub rms_with_old_um: Option<f64>,
    /// Residual of the later run with values of its own, µm rms.
    pub rms_with_new_um: Option<f64>,
    /// The same in sentences.
    pub words: Vec<String>,
}
