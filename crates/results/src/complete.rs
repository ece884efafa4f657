//! How much of what was planned the runs hold.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Points planned, read, missing and excluded.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Complete {
    /// Points that the recorded cycles ask for; null where no run says what was planned.
    pub planned: Option<usize>,
    /// Points read, outliers included.
    pub read: usize,
    /// Planned points without a reading, by run and setup.
    pub missing: Vec<Missing>,
    /// Points that were read and do not take part.
    pub excluded: Vec<Excluded>,
}

/// Points of one setup of one run that nothing was read at.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Missing {
    /// Name of the run.
    pub run: String,
    /// Name of the setup.
    pub setup: String,
    /// How many are missing.
    pub count: usize,
    /// How many the cycle asks for.
    pub planned: usize,
    /// Which, counted from 1 within the run, e.g. `3, 11 to 72`.
    pub points: String,
}

/// Points that do not take part, for one reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Excluded {
    /// Why.
    pub reason: String,
    /// How many.
    pub count: usize,
}

impl Complete {
    /// With points that a fit excluded.
    #[must_use]
    pub fn with_outliers(mut self, count: usize) -> Self {
        if count > 0 {
            self.excluded.push(Excluded { reason: "far from the rest of the fit".into(), count });
        }
        self
    }

    /// Points without a reading.
    pub fn missing_count(&self) -> usize {
        self.missing.iter().map(|missing| missing.count).sum()
    }
}
