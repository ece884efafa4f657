//! How a course is laid out, and its steps.

use super::super::visit::Pace;
use trunnion_core::{AxisValues, Joint};

/// How a course is laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CourseRules {
    /// Run-in, settling and the feed limits of axes whose machine file gives none.
    pub pace: Pace,
    /// Largest distance of the tool point from its path over the table in the straight pieces of a sweep, mm.
    pub chord_mm: f64,
    /// The same on the way from pose to pose, mm.
    pub transfer_chord_mm: f64,
    /// Largest speed of a linear axis from pose to pose, mm/s.
    pub transfer_mm_per_s: f64,
    /// Largest speed of a rotary axis from pose to pose, rad/s.
    pub transfer_rad_per_s: f64,
    /// Height of the retracted spindle above the highest ball, mm.
    pub clearance_mm: f64,
    /// True where the NC program leaves the linear axes to the tool centre point control of the machine.
    pub tool_point: bool,
    /// Number of the NC program, where the dialect has numbers; `None`: it follows from the name of the cycle.
    pub program_number: Option<u32>,
    /// Dwell at a pose at rest, s; `None`: settling and two windows of the cycle.
    pub dwell_s: Option<f64>,
    /// Length of one stroke of the synchronisation move that begins and ends a cycle on the fly, mm.
    pub stroke_mm: f64,
    /// Strokes of the synchronisation move, each there and back.
    pub strokes: usize,
}

impl Default for CourseRules {
    /// Chords of 0.5 µm in sweeps and 50 µm between poses, 2000 mm/min and 1800°/min, 100 mm clearance, three strokes of
    /// 0.2 mm.
    fn default() -> Self {
        Self {
            pace: Pace::default(),
            chord_mm: 0.5e-3,
            transfer_chord_mm: 0.05,
            transfer_mm_per_s: 2000.0 / 60.0,
            transfer_rad_per_s: std::f64::consts::TAU * 5.0 / 60.0,
            clearance_mm: 100.0,
            tool_point: false,
            program_number: None,
            dwell_s: None,
            stroke_mm: 0.2,
            strokes: 3,
        }
    }
}

impl CourseRules {
    /// Dwell at a pose at rest of a cycle with windows so long, s.
    pub fn dwell_of(&self, window_s: f64) -> f64 {
        self.dwell_s.unwrap_or(self.pace.settle_s + 2.0 * window_s)
    }
}

/// One step of a course. Positions are of all axes, mm and rad; every move is straight in axis space.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The spindle stands free above a setup: first in height, then the rotary axes, then over the place.
    Above {
        /// Where.
        at: AxisValues<f64>,
    },
    /// The operator fits what is named by the setups; the spindle is free.
    Fit {
        /// Indices of the setups.
        setups: Vec<usize>,
    },
    /// Straight down: ball and nest come together, or the table's ball comes within a bar's length.
    Join {
        /// Index of the setup.
        setup: usize,
        /// Where they are together.
        at: AxisValues<f64>,
        /// True when the operator has to see to it (a bar to put in, probes to look at).
        attended: bool,
    },
    /// Straight up again; a bar is taken out first.
    Part {
        /// Index of the setup.
        setup: usize,
        /// Where the spindle is free.
        to: AxisValues<f64>,
    },
    /// Along straight pieces, each at the speed the slowest axis allows.
    Transfer {
        /// End and duration, s, of every piece.
        pieces: Vec<(AxisValues<f64>, f64)>,
    },
    /// Dwell until the pose is read.
    Dwell {
        /// How long, s.
        seconds: f64,
    },
    /// Dwell for another reason.
    Wait {
        /// How long, s.
        seconds: f64,
        /// Why.
        reason: &'static str,
    },
    /// A small motion that is seen by axes and by probes.
    SyncMove {
        /// The axis that strokes.
        axis: Joint,
        /// End and duration, s, of every stroke.
        pieces: Vec<(AxisValues<f64>, f64)>,
    },
    /// At the feed of the cycle through pieces of equal duration.
    Sweep {
        /// The axis at its feed; `None` along a curve.
        turning: Option<Joint>,
        /// Signed feed, rad/s of that axis or of the angle along the curve.
        feed: f64,
        /// Duration of every piece, s.
        piece_s: f64,
        /// Ends of the pieces; run-in and run-out included.
        ends: Vec<AxisValues<f64>>,
    },
}
