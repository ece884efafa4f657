//! Errors of each axis over its own travel, for compensation tables.

use crate::left_out::LeftOutEffect;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_core::Twist;
use trunnion_core::convert::deg_from_rad;
use trunnion_methods as methods;

/// `trunnion-axis-errors/1`: the errors of all axes that a model can put into tables. Unlike other answers in mm and rad, as
/// controls take them; positions in mm and degrees.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisErrors {
    /// Format and version.
    pub format: AxisErrorsFormat,
    /// Name of the machine.
    pub machine: String,
    /// Names of the runs that the model was fitted to.
    pub runs: Vec<String>,
    /// Axes with any error, from the bed: table side, then tool side.
    pub axes: Vec<AxisTable>,
    /// Constant error of place and direction of the tool against the last joint that carries it, about the origin of the tool axes: zero
    /// but for a control that has no place for what the axes do to the tool. X Y Z A B C, mm and rad.
    #[serde(default)]
    pub tool: [f64; 6],
    /// Ids of the effects that are in the tables.
    pub effects: Vec<String>,
    /// What is not in the tables.
    pub left_out: Vec<LeftOutEffect>,
    /// Parameters of which only a combination is known, and what stands for it in the tables.
    #[serde(default)]
    pub confounded: Vec<ConfoundedErrors>,
}

/// Parameters of which the runs determine only a combination.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ConfoundedErrors {
    /// Those in the tables, which stand for all.
    pub entered: Vec<String>,
    /// Those that are zero in the tables.
    pub zero: Vec<String>,
}

impl ConfoundedErrors {
    /// What to know before it is entered.
    pub fn sentence(&self) -> String {
        let all: Vec<&str> = self.entered.iter().chain(&self.zero).map(String::as_str).collect();
        format!(
            "only the combination of {} is known; it is entered through {}, which is right at the measured poses and may be wrong at others",
            all.join(", "),
            self.entered.join(", ")
        )
    }
}

impl From<&methods::Confounded> for ConfoundedErrors {
    fn from(confounded: &methods::Confounded) -> Self {
        Self { entered: confounded.entered.clone(), zero: confounded.zero.clone() }
    }
}

/// Format and version of axis errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum AxisErrorsFormat {
    /// The first.
    #[default]
    #[serde(rename = "trunnion-axis-errors/1")]
    V1,
}

/// The errors of one axis: actual − nominal pose of what the axis carries, in the nominal axes of what carries the axis.
/// Components in the order X Y Z A B C, mm and rad.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AxisTable {
    /// Name of the axis.
    pub axis: String,
    /// True for a rotary axis.
    pub rotary: bool,
    /// Constant errors of place and direction.
    pub location: [f64; 6],
    /// Positions of the rows, mm or degrees, rising; empty without component errors.
    pub positions: Vec<f64>,
    /// Component errors at them.
    pub errors: Vec<[f64; 6]>,
    /// True when the table is a whole turn and goes on periodically.
    pub whole_turn: bool,
}

impl From<&methods::AxisErrors> for AxisErrors {
    fn from(errors: &methods::AxisErrors) -> Self {
        Self {
            format: AxisErrorsFormat::V1,
            machine: errors.machine.clone(),
            runs: errors.runs.clone(),
            axes: errors.axes.iter().map(AxisTable::from).collect(),
            tool: [0.0; 6],
            effects: errors.effects.clone(),
            left_out: errors.left_out.iter().map(LeftOutEffect::from).collect(),
            confounded: errors.confounded.iter().map(ConfoundedErrors::from).collect(),
        }
    }
}

impl From<&methods::AxisTable> for AxisTable {
    fn from(table: &methods::AxisTable) -> Self {
        let rotary = table.axis.is_rotary();
        let on_screen = |&position: &f64| if rotary { deg_from_rad(position) } else { position };
        Self {
            axis: table.axis.to_string(),
            rotary,
            location: components(&table.location),
            positions: table.positions.iter().map(on_screen).collect(),
            errors: table.errors.iter().map(components).collect(),
            whole_turn: table.whole_turn,
        }
    }
}

/// X Y Z A B C.
pub(crate) fn components(twist: &Twist) -> [f64; 6] {
    let ([x, y, z], [a, b, c]) = (twist.translation_mm.into(), twist.rotation_rad.into());
    [x, y, z, a, b, c]
}
