//! Why a motion cannot be judged.

use trunnion_cycles::VisitError;

/// A motion that cannot be judged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AttributionError {
    /// No axis positions.
    #[error(
        "recording {run} holds {found} axis positions, {least} are needed; record with the CNC connected, or simulate a cycle on the fly"
    )]
    NoAxes {
        /// The recording.
        run: String,
        /// Samples found.
        found: usize,
        /// Samples needed.
        least: usize,
    },
    /// A knot distance that the samples cannot support.
    #[error(
        "a smooth path with knots every {knot_s} s is not possible here; allowed: {low:.3}..={high:.3} s"
    )]
    Knots {
        /// As asked.
        knot_s: f64,
        /// Smallest possible.
        low: f64,
        /// Largest possible.
        high: f64,
    },
    /// A smooth path that cannot follow the axes.
    #[error(
        "recording {run}: a smooth path with knots every {knot_s} s leaves {peak_um:.1} µm of {axis}, one with knots every {} s {finer_um:.1} µm, so that \
         the bends of its path and its errors are not separated. Import the table with the commanded positions next to those of the encoders (x_mm and \
         x_actual_mm), or try a smaller --knot-s",
        knot_s / 2.0
    )]
    Bends {
        /// The recording.
        run: String,
        /// The axis with the largest share.
        axis: String,
        /// Distance of the knots.
        knot_s: f64,
        /// Its largest deviation.
        peak_um: f64,
        /// The largest of any axis with twice the knots.
        finer_um: f64,
    },
    /// The cycle does not fit the machine.
    #[error("the cycle of recording {run} cannot be run on its machine")]
    Cycle {
        /// The recording.
        run: String,
        /// Why.
        #[source]
        source: VisitError,
    },
    /// No pose for a measured or ideal position.
    #[error(
        "recording {run}: the machine has no pose for the axis positions at {time_s:.3} s; was it recorded on another machine?"
    )]
    NoPose {
        /// The recording.
        run: String,
        /// When.
        time_s: f64,
    },
}

impl AttributionError {
    /// True where the recording is why, and not what was asked of it.
    pub fn is_of_runs(&self) -> bool {
        match self {
            Self::NoAxes { .. } | Self::Cycle { .. } | Self::NoPose { .. } => true,
            // Without any possible distance the recording is too short for a path.
            Self::Knots { low, high, .. } => low > high,
            Self::Bends { .. } => false,
        }
    }
}
