//! What one kernel of the noise is.

use super::Real;
use nalgebra::DMatrix;

/// The frame of the readings is the first.
pub(super) const OF_READINGS: usize = 0;

/// One kernel.
pub(crate) struct Kernel {
    pub part: Part,
    pub frame: usize,
    pub over: Over,
    /// ln m.
    pub mean_ln: f64,
    /// σ of ln ρ.
    pub spread_ln: f64,
}

impl Kernel {
    /// Of the prior.
    pub fn precision(&self) -> f64 {
        self.spread_ln.powi(-2)
    }

    /// What one channel scatters beyond the others: white.
    pub fn is_white(&self) -> bool {
        self.part == Part::Channel
    }

    /// Offsets of the readings at each stop of the slow axis.
    pub fn is_station_of_readings(&self) -> bool {
        self.part == Part::Station && self.frame == OF_READINGS
    }
}

/// What a kernel is, in kinds that a person tells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Offsets from pass to pass, and of mountings.
    Pass,
    /// Scatter when an axis is positioned again.
    Station,
    /// Slow wandering.
    Drift,
    /// A pattern over the poses that comes back.
    Pattern,
    /// White noise of one channel beyond that of the others.
    Channel,
}

impl Part {
    /// Those that a machine has or has not; channels always differ.
    pub const OPTIONAL: [Self; 4] = [Self::Pass, Self::Station, Self::Drift, Self::Pattern];
}

/// Points that a kernel moves alike.
pub(crate) enum Over {
    /// Point × point.
    Pairs(DMatrix<Real>),
    /// Every point by itself.
    Own,
}
