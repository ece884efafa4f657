//! How well the samples of a run are known in time.

use trunnion_core::Joint;

/// Time quality of one run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeQuality {
    /// Name of the run.
    pub run: String,
    /// Every stream of samples: the probe channels, then the controller.
    pub streams: Vec<StreamTiming>,
    /// Synchronisation moves found.
    pub sync_moves: Vec<SyncMove>,
    /// What a person should know, one sentence each.
    pub notes: Vec<String>,
}

/// One stream of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StreamTiming {
    /// Channel or `controller`.
    pub name: String,
    /// Samples recorded.
    pub samples: u64,
    /// Mean rate, 1/s.
    pub rate_hz: f64,
    /// Lines fitted: one for each connection, and one more after each jump of the clock.
    pub lines: usize,
    /// Drift of the device's clock against the host's, weighted by samples, 1e-6; `None` without arrivals, or while a run is too
    /// short to show it.
    pub drift_ppm: Option<f64>,
    /// Spread of the arrivals about the line (rms), s: the error of a sample stamped on arrival.
    pub jitter_before_s: Option<f64>,
    /// Spread of the earliest arrivals of the quarters of the run about the line (rms), s: what the line does not follow.
    pub jitter_after_s: Option<f64>,
    /// Gaps, and their length together, s.
    pub gaps: (usize, f64),
    /// Samples known to be lost.
    pub lost: u64,
    /// Largest difference between the stamps of the axes in one reading, s; 0 with one stamp for all.
    pub skew_s: f64,
    /// Readings in which the controller said only that nothing had changed.
    pub held: u64,
    /// Delay of the stream against the axes with its standard uncertainty, s, from the synchronisation moves; already taken out of the times.
    pub delay_s: Option<(f64, f64)>,
}

/// A synchronisation move: strokes of one linear axis that axes and probes both see.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncMove {
    /// When it began, s since the run began.
    pub time_s: f64,
    /// The axis.
    pub axis: Joint,
    /// Length of a stroke, mm.
    pub stroke_mm: f64,
    /// What each channel saw.
    pub seen: Vec<SyncMoveDelay>,
}

/// One channel in a synchronisation move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SyncMoveDelay {
    /// Channel.
    pub channel: u16,
    /// By how much the readings come after the axes, s.
    pub delay_s: f64,
    /// Its standard uncertainty, s.
    pub u_s: f64,
    /// Change of the reading by the motion of the axis, mm/mm.
    pub gain: f64,
    /// What the fit leaves (rms), mm.
    pub rms_mm: f64,
}
