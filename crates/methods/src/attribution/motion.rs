//! A motion that can be judged, and where its ideal comes from.

use trunnion_core::{AxisSample, AxisValues, Joint};
use trunnion_cycles::Cycle;
use trunnion_machine::Machine;

/// A motion that can be judged.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Name of the recording.
    pub run: &'a str,
    /// The machine.
    pub machine: &'a Machine,
    /// Positions by the axes' own encoders, in order of time.
    pub samples: &'a [AxisSample],
    /// The cycle that was run.
    pub cycle: Option<&'a Cycle>,
    /// Where the control asked the axes to be at each sample, mm and rad, where a table says so.
    pub commanded: Option<&'a [AxisValues<f64>]>,
    /// Distance of the knots of a smooth path, s: what lasts longer passes for the path.
    pub knot_s: f64,
}

/// Where the ideal motion comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Ideal {
    /// The cycle: the turning axis, or the way along its curve, at a constant feed, the others as it commands them.
    Cycle {
        /// Name of the cycle.
        name: String,
        /// The axis that turns; `None` along a curve.
        turning: Option<Joint>,
    },
    /// What the control asked for at each sample.
    Commanded {
        /// Why not the cycle; empty when there was none.
        why: String,
    },
    /// A smooth path through the measured positions of each axis.
    Smooth {
        /// Distance of the knots, s.
        knot_s: f64,
        /// Why not the cycle; empty when there was none.
        why: String,
    },
}

/// Samples that no figure holds, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Of a pass, before its feed is reached and after it is left.
    pub run_in_and_out: usize,
    /// Of no pass: synchronisation moves, dwells, ways back. On a smooth path: of stretches too short for it.
    pub elsewhere: usize,
}
