//! What switching an effect on or off does to every reading, to first order.
//!
//! `residual of a set = residual of the model − change of the set`; changes of several sets add.

use crate::number::rounded;
use crate::residuals::{ResidualAxis, ResidualPoint, ResidualSetup};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `trunnion-linear/2`: points and solutions for what-if.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Linear {
    /// Format and version.
    pub format: LinearFormat,
    /// Axes of the machine; positions and directions of the points are in this order.
    pub axes: Vec<ResidualAxis>,
    /// Setups; the points give their index.
    pub setups: Vec<ResidualSetup>,
    /// Points in the order in which they were taken.
    pub points: Vec<LinearPoint>,
    /// Residual of the model, µm; rows are the components of point after point.
    pub residual_um: Vec<f64>,
    /// The fit of the model first, then each change of one effect: without one that was added, with one candidate.
    pub solutions: Vec<LinearSolution>,
}

/// Format and version of a linear fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LinearFormat {
    /// The second: what a set changes, not the columns that it is made of.
    #[default]
    #[serde(rename = "trunnion-linear/2")]
    V2,
}

/// Where a point was.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LinearPoint {
    /// Index of its setup.
    pub setup: usize,
    /// Commanded position of each axis, mm and degrees.
    pub position: Vec<f64>,
    /// Direction of each axis in the pass that the point belongs to: −1, 0 (unknown), +1.
    pub direction: Vec<i8>,
    /// Time since the run began, s; null without time stamps.
    pub time_s: Option<f64>,
}

/// A fit of one set of effects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LinearSolution {
    /// The effect that this set has more or less than the model; empty for the model itself.
    pub changed: String,
    /// Its name for a person.
    pub title: String,
    /// True where the effect is in the model and this is the fit without it.
    pub without: bool,
    /// What this set takes off the residual of the model, µm, a value for each row; empty for the model itself.
    pub change_um: Vec<f64>,
    /// Root mean square of the fit, µm.
    pub rms_um: f64,
    /// The same as a person reads it.
    pub rms: String,
    /// Indices of the points that the fit excluded.
    pub excluded: Vec<usize>,
}

/// `trunnion-formula/1`: an expression as far as it is typed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FormulaChecked {
    /// Format and version.
    pub format: FormulaFormat,
    /// True when the model could hold it.
    pub valid: bool,
    /// What is wrong, and what is allowed; empty when nothing is.
    pub problem: String,
    /// Names of its parameters.
    pub parameters: Vec<String>,
    /// Names of its shape numbers.
    pub shapes: Vec<String>,
}

/// Format and version of a checked expression.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum FormulaFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-formula/1")]
    V1,
}

impl From<&ResidualPoint> for LinearPoint {
    /// With more decimals than a page shows, and no more: there may be 10 000 of them.
    fn from(point: &ResidualPoint) -> Self {
        Self {
            setup: point.setup,
            position: point.position.iter().map(|&position| rounded(position, 4)).collect(),
            direction: point.direction.clone(),
            time_s: point.time_s.map(|time_s| rounded(time_s, 3)),
        }
    }
}
