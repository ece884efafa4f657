//! What a cycle gives: points, and what else a reader of the recording should know.

use crate::sweep_cycle::SampleCounts;
use trunnion_core::{AxisValues, Event, Point};

/// What happened.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a few events a minute, nearly all of them points")]
pub enum CycleEvent {
    /// The point of a pose; poses come in order, each once.
    Point {
        /// Index of the pose.
        pose: usize,
        /// What was read.
        point: Point,
        /// When it was decided, s since the run began.
        time_s: f64,
    },
    /// A dwell at none of the poses to come, for the log.
    UnknownDwell {
        /// When it began, s since the run began.
        time_s: f64,
        /// Where.
        position: AxisValues<f64>,
    },
    /// What became of the samples of a cycle on the fly.
    Samples {
        /// When the cycle ended, s.
        time_s: f64,
        /// Used and excluded ones.
        counts: SampleCounts,
    },
    /// The cycle is over; nothing comes after it.
    Ended {
        /// Why.
        reason: EndReason,
        /// When, s since the run began.
        time_s: f64,
    },
}

/// Why a cycle ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// Every pose has its point.
    Complete,
    /// The controller says that its program ended.
    ControllerEnded,
    /// No axis moved for too long.
    NoMotion,
    /// The recording ended or a person stopped it.
    Stopped,
}

/// How far a cycle is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Points decided.
    pub done: usize,
    /// Points in all.
    pub total: usize,
    /// At the pace so far; `None` before the second point.
    pub seconds_left: Option<f64>,
}

impl CycleEvent {
    /// The point, or the entry of a recording for what is none.
    ///
    /// # Errors
    /// The entry.
    pub fn into_point(self) -> Result<Point, Event> {
        match self {
            Self::Point { point, .. } => Ok(point),
            Self::UnknownDwell { time_s, position } => {
                let text = format!("dwell at none of the poses to come: {:?}", position.0);
                Err(Event { time_s, kind: "unknown-dwell".into(), text })
            }
            Self::Samples { time_s, counts } => {
                let text = counts.summary().unwrap_or_else(|| "no sample in any pass of the cycle".into());
                Err(Event { time_s, kind: "samples".into(), text })
            }
            Self::Ended { reason, time_s } => {
                Err(Event { time_s, kind: "cycle-end".into(), text: format!("{reason:?}") })
            }
        }
    }
}
