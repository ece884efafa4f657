//! How well the samples of a run are known in time.

use crate::number::finite;
use crate::topics::Published;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trunnion_sync::time_quality as sync;

/// Time quality of one run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TimeQuality {
    /// Name of the run.
    pub run: String,
    /// Every stream of samples: the probe channels, then the controller.
    pub streams: Vec<Stream>,
    /// Synchronisation moves found.
    #[serde(alias = "gestures")]
    pub sync_moves: Vec<SyncMove>,
    /// What a person should know, one sentence each.
    pub notes: Vec<String>,
}

impl Published for TimeQuality {
    const TOPIC: &'static str = "quality";
    const SCHEMA: &'static str = "time-quality";
}

/// One stream of samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stream {
    /// Channel or `controller`.
    pub name: String,
    /// Samples recorded.
    pub samples: u64,
    /// Mean rate, 1/s.
    pub rate_hz: Option<f64>,
    /// Lines fitted to its clock.
    pub lines: usize,
    /// Drift of the device's clock against the host's, 1e-6.
    pub drift_ppm: Option<f64>,
    /// Spread of the arrivals about the line (rms), s.
    pub jitter_before_s: Option<f64>,
    /// What the line does not follow (rms), s.
    pub jitter_after_s: Option<f64>,
    /// Gaps.
    pub gaps: usize,
    /// Their length together, s.
    pub gap_s: f64,
    /// Samples known to be lost.
    pub lost: u64,
    /// Largest difference between the stamps of the axes in one reading, s.
    pub skew_s: f64,
    /// Readings in which the controller reported only that nothing had changed.
    pub held: u64,
    /// Delay against the axes, s, already taken out of the times.
    pub delay_s: Option<f64>,
    /// Its standard uncertainty, s.
    pub delay_u_s: Option<f64>,
}

/// A synchronisation move: strokes of one linear axis that axes and probes both see.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SyncMove {
    /// When it began, s since the run began.
    pub time_s: f64,
    /// The axis.
    pub axis: String,
    /// Length of a stroke, mm.
    pub stroke_mm: f64,
    /// What each channel saw.
    pub channels: Vec<SyncMoveChannel>,
}

/// One channel in a synchronisation move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SyncMoveChannel {
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

impl From<&sync::TimeQuality> for TimeQuality {
    fn from(quality: &sync::TimeQuality) -> Self {
        Self {
            run: quality.run.clone(),
            streams: quality.streams.iter().map(Stream::from).collect(),
            sync_moves: quality.sync_moves.iter().map(SyncMove::from).collect(),
            notes: quality.notes.clone(),
        }
    }
}

impl From<&sync::StreamTiming> for Stream {
    fn from(stream: &sync::StreamTiming) -> Self {
        Self {
            name: stream.name.clone(),
            samples: stream.samples,
            rate_hz: finite(stream.rate_hz),
            lines: stream.lines,
            drift_ppm: stream.drift_ppm.and_then(finite),
            jitter_before_s: stream.jitter_before_s.and_then(finite),
            jitter_after_s: stream.jitter_after_s.and_then(finite),
            gaps: stream.gaps.0,
            gap_s: stream.gaps.1,
            lost: stream.lost,
            skew_s: stream.skew_s,
            held: stream.held,
            delay_s: stream.delay_s.and_then(|delay| finite(delay.0)),
            delay_u_s: stream.delay_s.and_then(|delay| finite(delay.1)),
        }
    }
}

impl From<&sync::SyncMove> for SyncMove {
    fn from(sync_move: &sync::SyncMove) -> Self {
        let channel = |seen: &sync::SyncMoveDelay| SyncMoveChannel {
            channel: seen.channel,
            delay_s: seen.delay_s,
            u_s: seen.u_s,
            gain: seen.gain,
            rms_mm: seen.rms_mm,
        };
        Self {
            time_s: sync_move.time_s,
            axis: sync_move.axis.to_string(),
            stroke_mm: sync_move.stroke_mm,
            channels: sync_move.seen.iter().map(channel).collect(),
        }
    }
}
