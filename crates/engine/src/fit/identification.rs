//! What a fit found: parameters, what could not be seen, residuals, and how far to trust them.
//!
//! Inside units throughout (mm, rad, s, K); [`FittedParameter::screen_value`] converts.
//! `residual = measured − predicted`.

use crate::fit::errors::Errors;
use crate::noise::learned::remainder::{Fitted, Learned};
use crate::problem::folds::LeftOut;
use crate::solve::combinations::Combination;
use crate::solve::direction::{Status, Unobservable};
use crate::written::{instrument, matrix, vector};
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_core::InstrumentKind;
use trunnion_effects::{FixedText, Unit, fixed_text};

/// The result of [`crate::identify`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identification {
    /// Machine name.
    pub machine: String,
    /// Names of the runs fitted together.
    pub runs: Vec<String>,
    /// Effects of the model, in order, with the shape numbers used.
    pub effects: Vec<FittedEffect>,
    /// Number of points given to the fit, outliers included.
    pub points: usize,
    /// Every parameter of the model, effect after effect.
    pub parameters: Vec<FittedParameter>,
    /// Directions in parameter space that this run cannot see.
    pub unobservable: Vec<Unobservable>,
    /// Combinations of machine errors that are seen although none of them alone is.
    pub seen_together: Vec<Combination>,
    /// Parameter vector behind `predicted_mm`, inside units, in the order of `parameters`. What has no number in
    /// `parameters` still has an arbitrary (small) one here: never show it.
    #[serde(with = "vector")]
    pub solution: DVector<f64>,
    /// Covariance of `solution` under noise as machines make it, inside units; zero in the rows of parameters without uncertainty. Rows
    /// after those of `parameters` are of shape numbers that the fit found ([`FittedEffect::shape_in_covariance`]).
    #[serde(with = "matrix")]
    pub covariance: DMatrix<f64>,
    /// Exact prediction, mm; rows as in [`crate::Experiment`].
    #[serde(with = "vector")]
    pub predicted_mm: DVector<f64>,
    /// Measured − predicted, mm; all rows, outliers included.
    #[serde(with = "vector")]
    pub residual_mm: DVector<f64>,
    /// True for each point that took part in the fit; false for outliers.
    pub used: Vec<bool>,
    /// Points excluded by the robust loss.
    pub outliers: Vec<Outlier>,
    /// Root mean square of the scalar residuals of the points used, mm.
    pub rms_mm: f64,
    /// Repeatability of one scalar reading; `None` when too few poses were measured twice.
    pub repeatability: Option<Repeatability>,
    /// Parts of the noise from which the uncertainties follow; empty when they follow from clusters (pass × position of the
    /// slow axis) of the residual instead.
    pub noise_parts: Vec<NoisePart>,
    /// The noise that was learned, where the uncertainties follow from it: a diagnosis goes on from there.
    pub(crate) noise: Option<Learned>,
    /// Root of the weight of each row in the fit; mean square 1 over the rows used.
    #[serde(with = "vector")]
    pub row_weights: DVector<f64>,
    /// Noise of each run and instrument, as the readings were weighted.
    pub noise_by_run: Vec<GroupNoise>,
    /// Error on the unit left out of the fit; `None` when not asked for or when nothing can be left out.
    pub holdout: Option<Holdout>,
    /// Rank of the scaled design, conventions not yet applied.
    pub rank: usize,
    /// Condition number of the scaled design within its rank.
    pub condition: f64,
    /// Gauss–Newton steps of the last fit.
    pub iterations: usize,
    /// Scalar readings used minus parameters determined.
    pub degrees_of_freedom: usize,
}

/// One effect of the fitted model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedEffect {
    /// Effect id.
    pub id: String,
    /// Names of the shape numbers, with unit.
    pub shape_names: Vec<String>,
    /// Shape numbers used; empty when the effect has none.
    pub shape: Vec<f64>,
    /// Row of each shape number in the covariance; `None` for one that the model gives, that counts, or that is a moment.
    pub shape_in_covariance: Vec<Option<usize>>,
}

/// One parameter of the model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedParameter {
    /// Name, e.g. `EX0C`.
    pub name: String,
    /// Id of its effect.
    pub effect: String,
    /// Unit on files and screens.
    pub unit: Unit,
    /// Value, inside units; `None` when it cannot be seen.
    pub value: Option<f64>,
    /// Standard uncertainty, inside units; `None` when it cannot be seen or was held.
    pub u: Option<f64>,
    /// How its number came about.
    pub status: Status,
    /// Errors of axes at rest that are part of the value, as those axes stand, e.g. `EX0B`.
    pub at_rest: Vec<String>,
    /// A remark for a person; may be empty.
    pub note: String,
}

/// A point excluded by the robust loss.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outlier {
    /// Index in [`crate::Experiment::points`].
    pub point: usize,
    /// Name of the run.
    pub run: String,
    /// Name of the setup.
    pub setup: String,
    /// Axis positions in screen units, e.g. `B -30° C 120°`.
    pub pose: String,
    /// Length of the residual, mm.
    pub residual_mm: f64,
}

/// Scatter of one scalar reading when a pose is measured again. A property of the points: no model enters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Repeatability {
    /// Standard deviation, mm.
    pub sigma_mm: f64,
    /// How many times a pose was measured again.
    pub repeats: usize,
    /// Degrees of freedom behind the figure.
    pub degrees_of_freedom: usize,
    /// Whether the side from which axes came to a pose is in it.
    pub approach: Approach,
    /// Readings that are averaged in one of which this is the scatter, the mean: 1 for single readings.
    pub readings: f64,
}

/// From which sides axes came to the poses whose visits say how readings repeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Approach {
    /// From any: visits from one side differ no less.
    NoMatter,
    /// From one side: visits from both differ by more.
    OneSide,
    /// From both: no pose was visited twice from one side, so that backlash counts as scatter.
    BothSides,
}

/// A part of a machine's noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoisePart {
    /// What it is, in words.
    #[serde(deserialize_with = "fixed_text")]
    pub name: FixedText,
    /// Standard deviation (rms over the scalar readings; expected, given the residual), mm.
    pub sigma_mm: f64,
}

/// Noise of one instrument in one run. A reading counts with 1/(floor² + standard error²).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroupNoise {
    /// Name of the run.
    pub run: String,
    /// The instrument.
    #[serde(with = "instrument")]
    pub instrument: InstrumentKind,
    /// Scalar readings used.
    pub readings: usize,
    /// Root mean square of their residuals, mm.
    pub rms_mm: f64,
    /// What does not average down (robust), mm.
    pub floor_mm: f64,
    /// Standard error of the readings by their samples (rms), mm; zero when unknown.
    pub samples_mm: f64,
}

/// Prediction of data that took no part in the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holdout {
    /// Root mean square of the scalar residuals, mm.
    pub rms_mm: f64,
    /// The unit that was left out in turn.
    pub left_out: LeftOut,
    /// How many parts were left out in turn.
    pub parts: usize,
}

/// Share of the points that must have been read again for repeats to say how readings repeat
/// [docs/decisions/0002-thresholds-of-model-comparison.md].
const REPEATED_SHARE: f64 = 0.2;
/// The residual may be this times the repeatability, √(1 + 1.5²): what repeats leave out (offsets of passes, drift, natural motions) is
/// no finding up to 1.5 times the repeatability [docs/decisions/0002-thresholds-of-model-comparison.md].
const MOST_OF_REPEATABILITY: f64 = 1.8;

impl Repeatability {
    /// True where a residual is no larger than repeats allow.
    pub fn allows(&self, rms_mm: f64) -> bool {
        rms_mm <= MOST_OF_REPEATABILITY * self.sigma_mm
    }

    /// Of a single reading, mm.
    pub fn single_mm(&self) -> f64 {
        self.sigma_mm * self.readings.sqrt()
    }
}

impl FittedParameter {
    /// True when the parameter has a number.
    pub fn observable(&self) -> bool {
        matches!(self.status, Status::Identified | Status::Held)
    }

    /// Value in `unit`.
    pub fn screen_value(&self) -> Option<f64> {
        self.value.map(|value| value * self.unit.per_inside)
    }

    /// True when its number is that of the parameter alone, not what it shares with others that are zero by convention.
    pub fn stands_alone(&self) -> bool {
        self.note.is_empty()
    }

    /// Standard uncertainty in `unit`.
    pub fn screen_u(&self) -> Option<f64> {
        self.u.map(|u| u * self.unit.per_inside)
    }
}

impl Identification {
    /// What noise is learned from.
    pub(crate) fn fitted(&self) -> Fitted<'_> {
        Fitted {
            row_weights: &self.row_weights,
            residual_mm: &self.residual_mm,
            predicted_mm: &self.predicted_mm,
            used: &self.used,
            own: self.noise.as_ref(),
            other: None,
        }
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&FittedParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Standard uncertainty of each shape number of an effect; `None` where the fit did not find it, or it counts.
    pub fn shape_u(&self, effect: &FittedEffect) -> Vec<Option<f64>> {
        let u = |row: &Option<usize>| row.map(|row| self.covariance[(row, row)].max(0.0).sqrt());
        effect.shape_in_covariance.iter().map(u).collect()
    }

    /// How well readings repeat; `None` where too few poses were measured twice to judge a residual by.
    pub fn known_repeatability(&self) -> Option<Repeatability> {
        self.repeatability.filter(|found| found.repeats as f64 >= REPEATED_SHARE * self.points as f64)
    }

    /// True where repeats show that the model leaves more than they allow. False says nothing: a small effect may be missing.
    pub fn exceeds_repeats(&self) -> bool {
        self.known_repeatability().is_some_and(|known| !known.allows(self.rms_mm))
    }

    /// Root mean square on held-out data, mm.
    pub fn holdout_rms_mm(&self) -> Option<f64> {
        self.holdout.map(|holdout| holdout.rms_mm)
    }

    pub(crate) fn errors(&self) -> Errors {
        Errors { rms_mm: self.rms_mm, holdout_rms_mm: self.holdout_rms_mm() }
    }
}
