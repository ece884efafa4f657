//! How much of what was planned the runs hold, and what is missing from them: one list for every surface.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_sync::SampleCounts;

/// Points planned, read, missing and excluded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Complete {
    /// Points that the recorded cycles ask for; null where no run says what was planned.
    pub planned: Option<usize>,
    /// Points read, outliers included.
    pub read: usize,
    /// Planned points without a reading, by run and setup.
    pub missing: Vec<Missing>,
    /// Points that were read and do not take part.
    pub excluded: Vec<Excluded>,
    /// What became of the samples of runs on the fly that hold their samples.
    #[serde(default)]
    pub samples: Vec<Samples>,
    /// What is missing from the recordings, one sentence each: gaps in what was asked of the devices, damage.
    #[serde(default)]
    pub losses: Vec<String>,
}

/// Samples of a run on the fly, taken inside the span of its cycle while the machine went the way of a pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Samples {
    /// Name of the run.
    pub run: String,
    /// How many there are.
    pub all: u64,
    /// Those that became points.
    pub used: u64,
    /// Their share of all.
    pub share_used: f64,
    /// Jitter of the stamps of the axes, ms (rms).
    pub jitter_ms: f64,
    /// Those that became none.
    pub excluded: Vec<ExcludedSamples>,
}

/// Samples that became no point, for one reason.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExcludedSamples {
    /// Why.
    pub reason: String,
    /// How many.
    pub count: u64,
    /// Their share of all.
    pub share: f64,
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

impl Samples {
    /// Those of a run; `None` when it has none.
    pub fn of(run: &str, counts: &SampleCounts) -> Option<Self> {
        let all = counts.all();
        let excluded = counts.excluded().into_iter().filter(|(count, _)| *count > 0);
        let excluded = excluded.map(|(count, reason)| ExcludedSamples {
            reason: reason.into(),
            count,
            share: count as f64 / all as f64,
        });
        Some(Self {
            run: run.into(),
            all,
            used: counts.used,
            share_used: counts.share_used()?,
            jitter_ms: 1e3 * counts.jitter_s().unwrap_or_default(),
            excluded: excluded.collect(),
        })
    }
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
}
