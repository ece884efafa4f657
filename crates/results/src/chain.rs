//! The nominal joints of a machine, as what a control has to know of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_machine::{Axis, Machine, Side};

/// The joints of a machine in series, from the bed outward.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Chain {
    /// Name of the machine.
    pub machine: String,
    /// Joints that carry the workpiece.
    pub table: Vec<ChainJoint>,
    /// Joints that carry the tool.
    pub tool: Vec<ChainJoint>,
    /// Point of the tool that was measured, the mean of all lengths, tool axes, mm.
    #[serde(default)]
    pub measured_in_tool_mm: [f64; 3],
}

/// One nominal joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChainJoint {
    /// Name of the axis.
    pub axis: String,
    /// True for a rotary axis.
    pub rotary: bool,
    /// True for a spindle that is a joint.
    #[serde(default)]
    pub spindle: bool,
    /// Direction of right-handed turning, or of travel, at zero, machine axes.
    pub direction: [f64; 3],
    /// A point of the line of a rotary axis at zero, machine coordinates, mm.
    pub through_mm: [f64; 3],
    /// +1: a positive coordinate moves the carried part along or right-handed about `direction`; −1: the other way.
    pub sense: f64,
}

impl Chain {
    /// The joints of a machine; `None` where legs in parallel carry the tool.
    pub fn of(machine: &Machine) -> Option<Self> {
        let joint = |axis| ChainJoint::of(axis, machine);
        let side = |side| machine.from_bed(side).into_iter().map(joint).collect();
        machine.tripod.is_none().then(|| Self {
            machine: machine.name.clone(),
            table: side(Side::Table),
            tool: side(Side::Tool),
            measured_in_tool_mm: [0.0; 3],
        })
    }

    /// Rotary joints that carry the workpiece, and those that carry the tool, each from the bed outward; without the spindle.
    pub fn rotary(&self) -> [Vec<&ChainJoint>; 2] {
        [&self.table, &self.tool].map(|side| side.iter().filter(|joint| joint.is_rotary_axis()).collect())
    }
}

impl ChainJoint {
    fn of(axis: &Axis, machine: &Machine) -> Self {
        Self {
            axis: axis.letter.to_string(),
            rotary: axis.is_rotary(),
            spindle: machine.spindle == Some(axis.letter),
            direction: axis.direction.into_inner().into(),
            through_mm: axis.through_mm.coords.into(),
            sense: axis.sense,
        }
    }

    /// True for a rotary axis that a control knows as one, which a spindle is not.
    pub fn is_rotary_axis(&self) -> bool {
        self.rotary && !self.spindle
    }
}
