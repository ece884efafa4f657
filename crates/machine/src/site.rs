//! Where an error acts.

use crate::JointErrors;
use nalgebra::Vector3;
use trunnion_core::{Joint, Twist};

/// Where an error acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Site {
    /// The joint of an axis: a twist of the carried component in the axes of the carrying one.
    Joint(Joint),
    /// The ball, nest or artefact on the table: its actual minus nominal place, table axes; an artefact also turns, about
    /// its origin.
    TableBall,
    /// The ball or nest in the spindle: its actual minus nominal place, tool axes (translation only).
    SpindleBall,
    /// The reading itself, nest axes (translation only); a ball bar uses the first component.
    Reading,
    /// An inner unknown of the instrument by number (tilt of a mirror, length of an arm), mm or rad: the x of the
    /// translation.
    Instrument(usize),
}

/// Most inner unknowns an instrument has.
pub const MOST_INNER: usize = 4;

/// All errors present at one instant, summed by site.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Errors {
    /// At each joint.
    pub joints: JointErrors,
    /// Displacement of the ball, nest or artefact on the table, table axes.
    pub table_ball: Twist,
    /// Offset of the ball or nest in the spindle, tool axes, mm.
    pub spindle_ball_mm: Vector3<f64>,
    /// Offset of the reading, nest axes, mm.
    pub reading_mm: Vector3<f64>,
    /// Inner unknowns of the instrument, mm or rad.
    pub instrument: [f64; MOST_INNER],
}

impl Errors {
    /// Adds `twist` at `site`.
    pub fn add(&mut self, site: Site, twist: Twist) {
        match site {
            Site::Joint(letter) => self.joints[letter] += twist,
            Site::TableBall => self.table_ball += twist,
            Site::SpindleBall => self.spindle_ball_mm += twist.translation_mm,
            Site::Reading => self.reading_mm += twist.translation_mm,
            Site::Instrument(k) => self.instrument[k] += twist.translation_mm.x,
        }
    }
}
