//! A machine as its joints, what each is and what carries what.

use crate::tripod::Tripod;
use nalgebra::{Point3, Unit, Vector3};
use trunnion_core::{Joint, Twist, names};

/// A machine as its file describes it (docs/design/contracts.md §3).
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Name of the file without its ending, e.g. `table-bc`.
    pub name: String,
    /// Axes that carry the workpiece, from the table down to the bed.
    pub table: Vec<Axis>,
    /// Axes that carry the tool, from the bed up to the tool.
    pub tool: Vec<Axis>,
    /// The legs that the first three axes of `tool` are the strokes of, where they carry a platform in parallel.
    pub tripod: Option<Tripod>,
    /// The spindle, where it is a joint: the last of `tool`. What is clamped in it turns with it.
    pub spindle: Option<Joint>,
}

/// One axis of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its letter (ISO 841).
    pub letter: Joint,
    /// Direction of a right-handed positive turn, or of positive travel, in machine axes at zero; of a leg the direction from
    /// its joint on the base to that on the platform.
    pub direction: Unit<Vector3<f64>>,
    /// A point on the axis line of a rotary axis at zero, in machine coordinates, mm.
    pub through_mm: Point3<f64>,
    /// +1: a positive coordinate moves the carried component right-handed along `direction`; −1: the other way.
    pub sense: f64,
    /// Smallest and largest coordinate, mm or rad.
    pub travel: (f64, f64),
    /// What else the machine builder knows of it.
    pub facts: AxisFacts,
}

/// Optional facts about an axis; an effect that needs one says so when it is missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisFacts {
    /// Lead of the ball screw, mm a turn.
    pub screw_lead_mm: Option<f64>,
    /// Teeth of the worm wheel or last gear, per turn of the axis.
    pub gear_teeth: Option<f64>,
    /// Rolling elements in one row of the bearing.
    pub bearing_rollers: Option<f64>,
    /// Lines of the angular encoder, per turn of the axis.
    pub encoder_lines: Option<f64>,
    /// Largest feed, mm/s or rad/s.
    pub feed_limit: Option<f64>,
}

/// Which branch of the chain an axis belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Between bed and workpiece.
    Table,
    /// Between bed and tool.
    Tool,
}

impl Machine {
    /// Axes of a side, from the bed outward.
    pub fn from_bed(&self, side: Side) -> Vec<&Axis> {
        match side {
            Side::Table => self.table.iter().rev().collect(),
            Side::Tool => self.tool.iter().collect(),
        }
    }

    /// Every axis: table side from the bed, then tool side from the bed.
    pub fn axes(&self) -> impl Iterator<Item = &Axis> {
        self.table.iter().rev().chain(&self.tool)
    }

    /// Its joints in the order of their slots: X Y Z A B C U V W, others among them.
    pub fn joints(&self) -> Vec<Joint> {
        let mut joints: Vec<Joint> = self.axes().map(|axis| axis.letter).collect();
        joints.sort();
        joints
    }

    /// Its linear joints in the order of their slots.
    pub fn linear_joints(&self) -> Vec<Joint> {
        self.joints().into_iter().filter(|joint| !joint.is_rotary()).collect()
    }

    /// Its rotary joints in the order of their slots.
    pub fn rotary_joints(&self) -> Vec<Joint> {
        self.joints().into_iter().filter(|joint| joint.is_rotary()).collect()
    }

    /// The joint called `name`, in upper or lower case.
    pub fn joint(&self, name: &str) -> Option<Joint> {
        self.axes().map(|axis| axis.letter).find(|joint| joint.as_str().eq_ignore_ascii_case(name))
    }

    /// What may stand in place of a `name` that no joint has.
    pub fn joints_near(&self, name: &str) -> String {
        names::allowed(name, self.joints().iter().map(|joint| joint.as_str()))
    }

    /// The axis with this letter.
    pub fn axis(&self, letter: Joint) -> Option<&Axis> {
        self.axes().find(|axis| axis.letter == letter)
    }

    /// Where the axis sits.
    pub fn side(&self, letter: Joint) -> Option<Side> {
        if self.table.iter().any(|axis| axis.letter == letter) {
            return Some(Side::Table);
        }
        self.tool.iter().any(|axis| axis.letter == letter).then_some(Side::Tool)
    }

    /// True for the stroke of a leg: its error moves the platform, and the joints take up all but what acts along it.
    pub fn is_leg(&self, letter: Joint) -> bool {
        self.tripod.as_ref().is_some_and(|tripod| tripod.has(letter))
    }

    /// The rotary axes, table side from the bed first.
    pub fn rotary(&self) -> Vec<&Axis> {
        self.axes().filter(|axis| axis.is_rotary()).collect()
    }
}

impl Axis {
    /// True for a rotary axis.
    pub fn is_rotary(&self) -> bool {
        self.letter.is_rotary()
    }

    /// The twist by which a unit of positioning error (1 mm, 1 rad) moves the carried component.
    pub fn positioning_twist(&self) -> Twist {
        let along = self.direction.into_inner() * self.sense;
        if self.is_rotary() { Twist::rotation(along) } else { Twist::translation(along) }
    }
}
