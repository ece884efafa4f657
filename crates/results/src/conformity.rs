//! Pass or fail against a tolerance, by the decision rule of ISO 14253-1 for an upper limit:
//! pass      E ≤ T − g,    fail      E ≥ T + g,    g = 1.65 u                                     [ISO 14253-1]
//! E the largest deviation, T the tolerance, u the standard uncertainty of E; 1.65 is the one-sided 95 % point of a normal
//! distribution. Between the two limits nothing is proven.
//! E is of the points in the fit. A point that was excluded from it fails no machine, and passes none either: where E passes and an excluded
//! point does not, nothing is decided until its pose is measured again. E itself is the same for every tolerance.
//! Limits: u is that of a reading about the model. What nobody recorded of the probes' calibration is not in it.

use crate::left_out::LeftOutEffect;
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
    /// The same with a correction that holds what tables of the axes can hold; what to expect, not what was measured.
    pub corrected: Judged,
    /// Effects of the machine that no table of an axis holds, and why: they are left in `corrected`.
    #[serde(default)]
    pub not_corrected: Vec<LeftOutEffect>,
    /// Why no control can be given anything of this machine, so that `corrected` is as measured; empty otherwise.
    #[serde(default)]
    pub why_not_corrected: String,
}

/// A deviation with its decision.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Judged {
    /// Largest deviation of the tool against the table over the points in the fit, µm.
    pub largest_um: f64,
    /// Its standard uncertainty, µm.
    pub u_um: f64,
    /// Where it was: setup and position.
    pub at: String,
    /// The points that were excluded from the fit; null where there are none.
    #[serde(default)]
    pub excluded: Option<ExcludedPoints>,
    /// The decision: none is a pass while an excluded point does not pass.
    pub decision: Decision,
}

/// Points that were excluded from the fit, where their deviation is largest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ExcludedPoints {
    /// How many.
    pub count: usize,
    /// Largest deviation of the tool against the table over them, µm.
    pub largest_um: f64,
    /// Where it was: setup and position.
    pub at: String,
}

impl Judged {
    /// The same, decided against a tolerance, µm.
    #[must_use]
    pub fn decided(self, tolerance_um: f64) -> Self {
        let of = |largest_um| Decision::of(largest_um, self.u_um, tolerance_um);
        let excluded = self.excluded.as_ref().map_or(Decision::Pass, |excluded| of(excluded.largest_um));
        let decision = match of(self.largest_um) {
            Decision::Pass if excluded != Decision::Pass => Decision::NotDecidable,
            of_fit => of_fit,
        };
        Self { decision, ..self }
    }

    /// True where every point is within the tolerance, µm, the excluded ones too.
    pub fn is_within(&self, tolerance_um: f64) -> bool {
        let excluded_um = self.excluded.as_ref().map_or(0.0, |excluded| excluded.largest_um);
        self.largest_um.max(excluded_um) <= tolerance_um
    }

    /// True where an excluded point alone keeps it from a pass against a tolerance, µm.
    pub fn waits_for_excluded(&self, tolerance_um: f64) -> bool {
        self.decision == Decision::NotDecidable
            && Decision::of(self.largest_um, self.u_um, tolerance_um) == Decision::Pass
    }
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
    fn an_excluded_point_changes_no_deviation_and_passes_nothing_until_it_is_measured_again() {
        let excluded = ExcludedPoints { count: 1, largest_um: 15.2, at: String::new() };
        let judged = Judged { largest_um: 1.4, u_um: 0.4, excluded: Some(excluded), ..Judged::default() };
        for (tolerance_um, expected, within, waits) in [
            (0.5, Decision::Fail, false, false),
            (1.5, Decision::NotDecidable, false, false),
            (8.0, Decision::NotDecidable, false, true),
            (15.5, Decision::NotDecidable, true, true),
            (16.0, Decision::Pass, true, false),
        ] {
            let of = judged.clone().decided(tolerance_um);
            assert_eq!((of.decision, of.largest_um), (expected, 1.4), "{tolerance_um}");
            assert_eq!(of.is_within(tolerance_um), within, "{tolerance_um}");
            assert_eq!(of.waits_for_excluded(tolerance_um), waits, "{tolerance_um}");
        }
    }

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
