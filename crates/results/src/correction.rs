//! What to enter into a control, what to check first, and what to expect.

use crate::axis_errors::{AxisErrors, ConfoundedErrors};
use crate::conformity::{Decision, ExcludedPoints};
use crate::diagnosis::Verdict;
use crate::left_out::LeftOutEffect;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-correction/1`: what was written for a control.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Correction {
    /// Format and version.
    pub format: CorrectionFormat,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs that the model was fitted to.
    pub runs: Vec<String>,
    /// Name of the control or of the format of tables.
    pub control: String,
    /// Sign of the values.
    pub values: CorrectionValues,
    /// What `diagnose` says of the model: a correction is as good as the model.
    pub verdict: Verdict,
    /// Ids of the effects that are in the tables of the axes.
    pub holds: Vec<String>,
    /// What this control does not get, and why.
    pub left_out: Vec<LeftOutEffect>,
    /// Parameters of which only a combination is known, and what stands for it.
    #[serde(default)]
    pub confounded: Vec<ConfoundedErrors>,
    /// What each axis gets.
    pub axes: Vec<CorrectedAxis>,
    /// What to expect; null where no reading shows the correction.
    pub expected: Option<Expected>,
    /// Two poses that show the sign; null where no pair of measured poses does.
    pub check_first: Option<SignCheck>,
    /// Where and how to enter the values, step by step.
    pub enter: Vec<String>,
    /// How to undo it.
    pub undo: Vec<String>,
    /// What no public document confirms.
    pub unconfirmed: Vec<String>,
    /// Where the format is described.
    pub source: String,
    /// Four poses that show the sign, where they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub self_test: Option<SelfTest>,
    /// The file that was written.
    pub written: String,
}

/// Format and version of a correction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum CorrectionFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-correction/1")]
    V1,
}

/// Sign of the values that are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CorrectionValues {
    /// actual − nominal.
    #[default]
    Error,
    /// −error.
    Correction,
}

impl CorrectionValues {
    /// What an error is multiplied by to become such a value.
    pub fn sign(self) -> f64 {
        match self {
            Self::Error => 1.0,
            Self::Correction => -1.0,
        }
    }
}

/// What one axis gets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectedAxis {
    /// The axis.
    pub axis: String,
    /// True where its place or direction is corrected.
    pub location: bool,
    /// Rows of its table of component errors.
    pub rows: usize,
    /// True when the table is a whole turn.
    pub whole_turn: bool,
}

/// Readings of these runs before and after the correction, settings of ball and instrument fitted again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Expected {
    /// Rms of the readings about the nominal machine, µm.
    pub before_um: f64,
    /// Rms expected when the same poses are measured again, µm: noise and everything that is not in the file.
    pub after_um: f64,
    /// The same with the wrong sign, µm.
    pub wrong_sign_um: f64,
    /// The largest of the readings expected then, µm.
    pub largest_after_um: f64,
    /// Tolerance of the machine file, µm; null where it states none.
    pub tolerance_um: Option<f64>,
    /// Whether the largest reading keeps the tolerance (ISO 14253-1); null without one.
    pub decision: Option<Decision>,
    /// Points that were excluded from the fit, expected then: nothing passes while they do not; null where there are none.
    #[serde(default)]
    pub excluded: Option<ExcludedPoints>,
}

impl Expected {
    /// True where the errors do not fall.
    pub fn is_no_better(&self) -> bool {
        self.after_um >= self.before_um
    }
}

/// Two poses whose readings say whether the sign is right.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SignCheck {
    /// Name of the setup.
    pub setup: String,
    /// Where to zero the instrument, e.g. `B 0.000° C 0.000°`.
    pub from: String,
    /// Where to read it.
    pub to: String,
    /// Names of the components of a reading.
    pub components: Vec<String>,
    /// Reading at `to` without the correction, µm, as the whole model predicts it: ball and instrument are mounted as in the runs.
    pub without_um: Vec<f64>,
    /// Reading with the right sign, µm: the errors that the control does not take stay in it.
    pub right_um: Vec<f64>,
    /// Reading with the wrong sign, µm.
    pub wrong_um: Vec<f64>,
}

/// Four poses that show the sign.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SelfTest {
    /// Name of the setup.
    pub setup: String,
    /// Names of the components of a reading.
    pub components: Vec<String>,
    /// The poses.
    pub poses: Vec<SelfTestPose>,
    /// The cycle file that was written.
    pub cycle: String,
    /// The command that makes its NC program; null where the values are for no controller that one is written for.
    #[serde(default)]
    pub program: Option<String>,
}

/// Readings at one pose of a self-test, about the mean of all its poses, as the whole model predicts them: ball and instrument are mounted as in
/// the runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SelfTestPose {
    /// The pose, e.g. `B 0.000° C 0.000°`.
    pub pose: String,
    /// Without the correction, µm.
    pub without_um: Vec<f64>,
    /// With the right sign, µm: the errors that the control does not take stay in it.
    pub right_um: Vec<f64>,
    /// With the wrong sign, µm.
    pub wrong_um: Vec<f64>,
}

/// `trunnion-correction-judged/1`: whether a control applies a correction, and with which sign, by a run measured with it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CorrectionJudged {
    /// Format and version.
    pub format: CorrectionJudgedFormat,
    /// Name of the control.
    pub control: String,
    /// Names of the runs measured with the correction.
    pub runs: Vec<String>,
    /// Share of the correction that acts: 1 right, 0 not active, −1 wrong sign.
    pub share: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// The answer in one word.
    pub verdict: SignVerdict,
    /// Rms of the readings about the nominal machine, settings fitted, µm.
    pub rms_um: f64,
    /// The same as expected without the correction, µm.
    pub without_um: f64,
    /// What the recorded positions of the linear axes hold of the correction; null where the commanded ones are not known (other instruments than an
    /// R-test).
    #[serde(default)]
    pub positions: Option<PositionShare>,
}

/// Share of a correction that stands in recorded positions: near 0 in commanded ones, the share that acts in those of the drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PositionShare {
    /// The share.
    pub share: f64,
    /// Its standard uncertainty.
    pub u: f64,
    /// True where it is sure and not small: the share that acts is then that of readings and positions together.
    pub counted: bool,
}

/// Format and version of a judged correction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum CorrectionJudgedFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-correction-judged/1")]
    V1,
}

/// What a run says of the sign of a correction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignVerdict {
    /// The correction acts with the right sign.
    Right,
    /// It does not act.
    NotActive,
    /// It acts with the wrong sign.
    Wrong,
    /// It acts by another share than all of it: some of the values were entered, or a value twice.
    InPart,
    /// It is too small against the noise of this run to say.
    #[default]
    Unclear,
}

impl SignVerdict {
    /// From the share of the correction that acts: right (1), not active (0) or wrong (−1), where it is within a quarter of it, half way to
    /// where it might as well be the next, or within twice its standard uncertainty. Where that reaches over half way between
    /// two, nothing is said.
    pub fn of(share: f64, u: f64) -> Self {
        const HALF_WAY: f64 = 0.5;
        const NEAR: f64 = 0.25;
        if u.is_nan() || 2.0 * u >= HALF_WAY {
            return Self::Unclear;
        }
        let answers = [(1.0, Self::Right), (0.0, Self::NotActive), (-1.0, Self::Wrong)];
        let near = answers.into_iter().find(|(of, _)| (share - of).abs() <= NEAR.max(2.0 * u));
        near.map_or(Self::InPart, |(_, answer)| answer)
    }
}

impl SignVerdict {
    /// The same with what the recorded positions hold. Readings about positions that depart from the commanded ones, and may hold all or nothing
    /// of the correction, cannot say that it does not act.
    pub fn of_readings(share: f64, u: f64, positions: Option<PositionShare>) -> Self {
        match Self::of(share, u) {
            Self::NotActive
                if positions
                    .is_some_and(|positions| Self::of(positions.share, positions.u) == Self::Unclear) =>
            {
                Self::Unclear
            }
            verdict => verdict,
        }
    }
}

impl Correction {
    /// What each axis gets of these errors.
    pub fn axes_of(errors: &AxisErrors) -> Vec<CorrectedAxis> {
        let axis = |table: &crate::AxisTable| CorrectedAxis {
            axis: table.axis.clone(),
            location: table.location.iter().any(|value| *value != 0.0),
            rows: table.positions.len(),
            whole_turn: table.whole_turn,
        };
        errors.axes.iter().map(axis).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_that_is_none_of_the_three_is_said_to_act_in_part() {
        let of = |share: f64| SignVerdict::of(share, 0.002);
        assert_eq!([1.0, 0.97, 1.2].map(of), [SignVerdict::Right; 3]);
        assert_eq!([0.6, 1.5, 0.45, -0.5, 2.0].map(of), [SignVerdict::InPart; 5]);
        assert_eq!([0.0, 0.2, -0.2].map(of), [SignVerdict::NotActive; 3]);
        assert_eq!(of(-1.1), SignVerdict::Wrong);
        assert_eq!(SignVerdict::of(0.6, 0.22), SignVerdict::Right, "as likely as not all of it");
        assert_eq!([0.3, f64::NAN].map(|u| SignVerdict::of(1.0, u)), [SignVerdict::Unclear; 2]);
    }
}
