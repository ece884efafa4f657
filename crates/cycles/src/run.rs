//! A run: everything one recording holds that identification needs.

use trunnion_core::{Point, Setup};
use trunnion_machine::Machine;

/// How the points came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunKind {
    /// Axes at rest at every point.
    Static,
    /// Samples taken while an axis turned.
    OnTheFly,
}

/// One recording, ready for identification.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name shown in reports (usually the file name).
    pub name: String,
    /// The machine it was measured on.
    pub machine: Machine,
    /// Static or on the fly.
    pub kind: RunKind,
    /// Setups; `Point::state.setup` indexes them.
    pub setups: Vec<Setup>,
    /// Names of the temperature channels.
    pub channels: Vec<String>,
    /// Points in the order they were taken.
    pub points: Vec<Point>,
}

impl Run {
    /// The points that identification may use.
    pub fn good_points(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().filter(|point| point.is_good())
    }

    /// True when every point has a time.
    pub fn has_time(&self) -> bool {
        self.points.iter().all(|point| point.state.time_s.is_some())
    }
}
