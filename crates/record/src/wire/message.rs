//! A message on its way to or from a file: topic, payload, and why it cannot be read.

use crate::item::RunHeader;
use prost::{DecodeError, Message};

/// Name of the message of a point.
pub const POINT_SCHEMA: &str = "trunnion.Point";
/// Names of the messages of what devices deliver.
pub const SAMPLE_SCHEMAS: [&str; 4] =
    ["trunnion.ProbeBatch", "trunnion.AxisBatch", "trunnion.Temperature", "trunnion.Gap"];

/// What a message is about; each has its MCAP topic and schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topic {
    Run,
    Probe(u16),
    Axes,
    Point,
    Temperature,
    Event,
    Gap,
    Plot(u16),
    PlotAxes,
}

impl Topic {
    /// Name of the MCAP channel.
    pub fn name(self, header: &RunHeader) -> String {
        let probe = |channel: u16| match header.probes.get(usize::from(channel)) {
            Some(name) if !name.is_empty() => name.clone(),
            _ => channel.to_string(),
        };
        match self {
            Self::Run => "/run".into(),
            Self::Probe(channel) => format!("/probe/{}", probe(channel)),
            Self::Axes => "/axes".into(),
            Self::Point => "/point".into(),
            Self::Temperature => "/temperature".into(),
            Self::Event => "/event".into(),
            Self::Gap => "/gap".into(),
            Self::Plot(channel) => format!("/plot/{}", probe(channel)),
            Self::PlotAxes => "/plot/axes".into(),
        }
    }

    /// Name of the protobuf message.
    pub fn schema(self) -> &'static str {
        match self {
            Self::Run => "trunnion.RunHeader",
            Self::Probe(_) => "trunnion.ProbeBatch",
            Self::Axes => "trunnion.AxisBatch",
            Self::Point => POINT_SCHEMA,
            Self::Temperature => "trunnion.Temperature",
            Self::Event => "trunnion.Event",
            Self::Gap => "trunnion.Gap",
            Self::Plot(_) => "trunnion.PlotSample",
            Self::PlotAxes => "trunnion.PlotAxes",
        }
    }
}

/// A message ready to be written.
#[derive(Clone, Debug)]
pub struct Encoded {
    pub topic: Topic,
    /// Acquisition time, s since the run began; what has no time counts as the start.
    pub time_s: f64,
    /// Time of the last sample in it, or end of the gap.
    pub until_s: f64,
    /// How many samples are lost with it.
    pub samples: u64,
    /// How many samples it says are missing, where it is a gap: these were counted before.
    pub missing: u64,
    pub payload: Vec<u8>,
}

pub(super) fn encoded(topic: Topic, time_s: f64, samples: usize, message: &impl Message) -> Encoded {
    Encoded {
        topic,
        time_s,
        until_s: time_s,
        samples: samples as u64,
        missing: 0,
        payload: message.encode_to_vec(),
    }
}

/// Why a message cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum WireError {
    #[error(transparent)]
    Protobuf(#[from] DecodeError),
    #[error("a {0} contradicts itself")]
    Inconsistent(&'static str),
}
