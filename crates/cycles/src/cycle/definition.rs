//! What a cycle file asks for, and the poses and passes that follow from it.

use super::path::{Line, Path};
use nalgebra::{Unit, Vector3};
use trunnion_core::{AxisValues, Joint};
use trunnion_machine::Machine;

/// What a cycle does.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Poses on a grid, read at rest.
    Static {
        /// The axes of the grid, the slowest first.
        grid: Vec<GridAxis>,
        /// +1: grid as written; −1: the whole grid backwards.
        passes: Vec<f64>,
        /// When a point may be read.
        settle: Settle,
    },
    /// A straight line of the tool, read at rest.
    Line {
        /// The line.
        line: Line,
        /// +1: as written; −1: backwards.
        passes: Vec<f64>,
        /// When a point may be read.
        settle: Settle,
    },
    /// A curve of the tool about the table's ball, sampled on the way.
    Path {
        /// The curve.
        path: Path,
        /// First and last angle on the curve, rad.
        from_to_rad: (f64, f64),
        /// Feeds along the curve, mm/s; every feed is run in every pass before the next feed.
        feeds_mm_per_s: Vec<f64>,
        /// +1: from first to last angle; −1: back.
        passes: Vec<f64>,
    },
    /// One rotary axis turning while sampled, others standing or turning in step with it.
    OnTheFly {
        /// The turning axis.
        axis: Joint,
        /// First and last angle, rad.
        from_to_rad: (f64, f64),
        /// Feeds, rad/s; every feed is run in every pass before the next feed.
        feeds_rad_per_s: Vec<f64>,
        /// +1: from first to last angle; −1: back.
        passes: Vec<f64>,
        /// Positions of the other rotary axes at the first and the last angle, rad: one whose two are equal stands
        /// [ISO 10791-6 BK3: two rotary axes at constant speeds].
        others: AxisValues<(f64, f64)>,
    },
}

/// How often a cycle is run, and in which order of its setups.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounds {
    /// How many times the whole cycle is run.
    pub count: usize,
    /// Dwell between two rounds, s.
    pub wait_s: f64,
    /// True: pass by pass through all setups, which all stay mounted.
    pub interleave: bool,
}

/// Where a ball bar points, from the table-side ball to the spindle-side ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Direction in `frame`.
    pub direction: Unit<Vector3<f64>>,
    /// What it keeps its direction in while the table turns.
    pub frame: BarFrame,
}

/// What a ball bar keeps its direction in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BarFrame {
    /// The machine: a rotary axis turns alone under the bar [S4: C-X, B-Z, …].
    Machine,
    /// The table: the bar turns with it.
    Table,
}

impl Default for Rounds {
    fn default() -> Self {
        Self { count: 1, wait_s: 0.0, interleave: false }
    }
}

impl Default for Bar {
    fn default() -> Self {
        Self { direction: Vector3::x_axis(), frame: BarFrame::Machine }
    }
}

/// Overrun of a linear axis so that it comes from the side of its pass, mm.
pub(super) const OVERRUN_MM: f64 = 5.0;
/// The same of a rotary axis, rad.
const OVERRUN_RAD: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// One axis of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxis {
    /// Which axis. Read from a file, one that is no letter has a name and no place yet: see [`GridAxis::on`].
    pub letter: Joint,
    /// Its stations in order, mm or rad.
    pub stations: Vec<f64>,
}

impl GridAxis {
    /// The same with the joint of `machine` that has its name (docs/decisions/0011-joints-by-name.md: a machine says where its joints
    /// have their places).
    #[must_use]
    pub fn on(&self, machine: &Machine) -> Self {
        let letter = machine.joint(self.letter.as_str()).unwrap_or(self.letter);
        Self { letter, stations: self.stations.clone() }
    }

    /// How far a row begins beyond its first station, so that the axis comes from the side of its pass, mm or rad. `None` for a linear axis with one
    /// station: it stays where ball and instrument came together, and a plate or an arm that measures in a plane leaves it no room.
    pub(super) fn overrun(&self) -> Option<f64> {
        match self.letter.is_rotary() {
            true => Some(OVERRUN_RAD),
            false => (self.stations.len() > 1).then_some(OVERRUN_MM),
        }
    }
}

/// When a static point may be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settle {
    /// Length of the window that is averaged, s.
    pub window_s: f64,
    /// Largest drift of any channel between the halves of the window, mm.
    pub drift_mm: f64,
    /// Largest robust spread of any channel in the window, mm.
    pub noise_mm: f64,
    /// Largest motion of a linear axis over the window that still counts as standing, mm.
    pub standstill_mm: f64,
    /// Largest motion of a rotary axis over the window that still counts as standing, rad.
    pub standstill_rad: f64,
    /// How long to wait for the point before marking it, s.
    pub timeout_s: f64,
}

/// One pose of a static cycle.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Index of the setup.
    pub setup: usize,
    /// Index of the target of its artefact.
    pub target: usize,
    /// All axes, mm and rad; the linear axes follow the ball unless the cycle names them.
    pub position: AxisValues<f64>,
    /// Direction of approach of each axis.
    pub direction: AxisValues<f64>,
}

/// One pass of a cycle on the fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Index of the setup.
    pub setup: usize,
    /// Feed of the turning axis, rad/s; negative towards smaller angles.
    pub feed_rad_per_s: f64,
}
