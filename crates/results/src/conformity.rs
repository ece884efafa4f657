//! Pass or fail against a tolerance, by the decision rule of ISO 14253-1 for an upper limit:
//! pass      E ≤ T − g,    fail      E ≥ T + g,    g = 1.65 u                                     [ISO 14253-1]
//! E the largest deviation, T the tolerance, u the standard uncertainty of E; 1.65 is the one-sided 95 % point of a normal
//! distribution. Between the two limits nothing is proven.
//! Limits: u is that of a reading about the model. What nobody recorded of the probes' calibration is not in it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Guard band in standard uncertainties [ISO 14253-1].
const GUARD_U: f64 = 1.65;

/// The largest deviation of a run against a tolerance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Conformity {
    /// The tolerance, µm.
    pub tolerance_um: f64,
    /// Where it is from.
    pub tolerance_of: String,
    /// The machine as it was measured: how the ball was set is taken off, nothing else.
    pub as_measured: Judged,
    /// The same once everything in the model is corrected; what to expect, not what was measured.
    pub corrected: Judged,
}

/// A deviation with its decision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// Largest deviation of the tool against the table over the points, µm.
    pub largest_um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
    /// Where it was: setup and position.
    pub at: String,
    /// The decision.
    pub decision: Decision,
}

/// Does a deviation keep a tolerance?
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Decision {
    /// It does, with 95 % probability or more.
    Pass,
    /// It does not, with 95 % probability or more.
    Fail,
    /// The uncertainty is too large to say.
    #[default]
    NotDecidable,
}

impl Decision {
    /// The decision on a deviation, µm.
    pub fn of(largest_um: f64, u_um: f64, tolerance_um: f64) -> Self {
        let guard_um = GUARD_U * u_um;
        match largest_um {
            deviation if deviation <= tolerance_um - guard_um => Self::Pass,
            deviation if deviation >= tolerance_um + guard_um => Self::Fail,
            _ => Self::NotDecidable,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
            Self::NotDecidable => "not decidable",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uncertainty_counts_against_whoever_claims() {
        // Limit 10 µm, u 1 µm: the guard band is 1.65 µm on both sides.
        assert_eq!(Decision::of(8.3, 1.0, 10.0), Decision::Pass);
        assert_eq!(Decision::of(8.4, 1.0, 10.0), Decision::NotDecidable);
        assert_eq!(Decision::of(11.6, 1.0, 10.0), Decision::NotDecidable);
        assert_eq!(Decision::of(11.7, 1.0, 10.0), Decision::Fail);
        assert_eq!(Decision::of(f64::NAN, 1.0, 10.0), Decision::NotDecidable);
        assert_eq!(Decision::of(1.0, f64::NAN, 10.0), Decision::NotDecidable);
    }
}
