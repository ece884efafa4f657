//! Where an error acts.

use crate::JointErrors;
use nalgebra::Vector3;
use trunnion_units::{AxisLetter, Twist};

/// Where an error acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Site {
    /// The joint of an axis: a twist of the carried component in the axes of the carrying one.
    Joint(AxisLetter),
    /// The ball or nest on the table: its actual minus nominal place, table axes (translation only).
    TableBall,
    /// The ball or nest in the spindle: its actual minus nominal place, tool axes (translation only).
    SpindleBall,
    /// The reading itself, nest axes (translation only); a ball bar uses the first component.
    Reading,
}

/// All errors present at one instant, summed by site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// At each joint.
    pub joints: JointErrors,
    /// Offset of the ball or nest on the table, table axes, mm.
    pub table_ball_mm: Vector3<f64>,
    /// Offset of the ball or nest in the spindle, tool axes, mm.
    pub spindle_ball_mm: Vector3<f64>,
    /// Offset of the reading, nest axes, mm.
    pub reading_mm: Vector3<f64>,
}

impl Errors {
    /// Adds `twist` at `site`.
    pub fn add(&mut self, site: Site, twist: Twist) {
        match site {
            Site::Joint(letter) => self.joints[letter] += twist,
            Site::TableBall => self.table_ball_mm += twist.translation_mm,
            Site::SpindleBall => self.spindle_ball_mm += twist.translation_mm,
            Site::Reading => self.reading_mm += twist.translation_mm,
        }
    }
}
