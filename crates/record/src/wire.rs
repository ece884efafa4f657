//! Items as protobuf messages and back.

mod calibration;
mod message;
mod samples;
mod setup;

pub use message::{Encoded, POINT_SCHEMA, SAMPLE_SCHEMAS, Topic, WireError};
pub use samples::{encode_axes, encode_probes, same_clock};

use crate::item::{Item, RunHeader, Temperature};
use crate::schema as pb;
use message::encoded;
use nalgebra::Vector3;
use prost::Message;
use samples::{axes_from, by_place, from_places, probes_from};
use trunnion_core::{
    AxisSample, Event, Gap, HostTime, Lacks, Point, ProbeSample, Quality, Role, Setup, State, convert,
};
use trunnion_cycles::RunKind;

/// A message read back.
#[expect(clippy::large_enum_variant, reason = "one at a time, passed on at once")]
pub enum Decoded {
    Header(RunHeader),
    /// A batch of one channel, in order of time.
    Probes(Vec<ProbeSample>),
    /// A batch in order of time.
    Axes(Vec<AxisSample>),
    /// `index` orders points; 0 for everything else.
    Item {
        index: u64,
        item: Item,
    },
    /// Derived or unknown; nothing to read.
    Skipped,
}

/// Reads one message.
pub fn decode(schema: &str, payload: &[u8]) -> Result<Decoded, WireError> {
    let item = match schema {
        "trunnion.RunHeader" => return Ok(Decoded::Header(header_from(pb::RunHeader::decode(payload)?)?)),
        POINT_SCHEMA => {
            let message = pb::Point::decode(payload)?;
            let index = message.index;
            return Ok(Decoded::Item { index, item: Item::Point(point_from(message)?) });
        }
        "trunnion.ProbeBatch" => {
            return Ok(Decoded::Probes(probes_from(pb::ProbeBatch::decode(payload)?)?));
        }
        "trunnion.AxisBatch" => return Ok(Decoded::Axes(axes_from(pb::AxisBatch::decode(payload)?)?)),
        "trunnion.ControllerState" => {
            let m = pb::ControllerState::decode(payload)?;
            let text = format!("{} {}", m.execution, m.program).trim().into();
            Item::Event(Event { time_s: m.time_s(), kind: "controller".into(), text })
        }
        "trunnion.Temperature" => {
            let m = pb::Temperature::decode(payload)?;
            let channel = u16::try_from(m.channel).map_err(|_| WireError::Inconsistent("Temperature"))?;
            Item::Temperature(Temperature { time_s: m.time_s(), channel, value_degc: m.value_degc })
        }
        "trunnion.Event" => {
            let m = pb::Event::decode(payload)?;
            Item::Event(Event { time_s: m.time_s(), kind: m.kind, text: m.text })
        }
        "trunnion.Gap" => {
            let m = pb::Gap::decode(payload)?;
            let (from_s, to_s, lost_samples) = (m.from_s(), m.to_s(), m.lost_samples);
            Item::Gap(Gap { source: m.source, from_s, to_s, lost_samples, reason: m.reason })
        }
        "trunnion.LogLine" => {
            let m = pb::LogLine::decode(payload)?;
            Item::Event(Event { time_s: m.time_s(), kind: m.level, text: m.text })
        }
        _ => return Ok(Decoded::Skipped),
    };
    Ok(Decoded::Item { index: 0, item })
}

/// The header as the first message; the texts travel as attachments.
pub fn encode_header(header: &RunHeader) -> Encoded {
    let message = pb::RunHeader {
        name: header.name.clone(),
        kind: match header.kind {
            RunKind::Static => "static".into(),
            RunKind::OnTheFly => "on-the-fly".into(),
        },
        machine: header.machine_name.clone(),
        setups: header.setups.iter().map(setup::encode).collect(),
        temperature_channels: header.temperature_channels.clone(),
        probes: header.probes.clone(),
        probe_roles: header.probe_roles.iter().map(|role| role.name().into()).collect(),
        calibrations: header.calibrations.iter().map(calibration::encode).collect(),
        software_version: header.software_version.clone(),
        wall_start_ns: header.wall_start_ns,
        host_start_ns: header.host_start.0,
    };
    encoded(Topic::Run, 0.0, 0, &message)
}

fn header_from(message: pb::RunHeader) -> Result<RunHeader, WireError> {
    let kind = match message.kind.as_str() {
        "static" => RunKind::Static,
        "on-the-fly" => RunKind::OnTheFly,
        _ => return Err(WireError::Inconsistent("RunHeader")),
    };
    let setups: Option<Vec<Setup>> = message.setups.into_iter().map(setup::decode).collect();
    let calibrations: Option<Vec<_>> = message.calibrations.into_iter().map(calibration::decode).collect();
    let roles: Option<Vec<Role>> = message.probe_roles.iter().map(|name| Role::named(name)).collect();
    Ok(RunHeader {
        name: message.name,
        kind,
        machine_name: message.machine,
        machine_text: String::new(),
        setups: setups.ok_or(WireError::Inconsistent("RunHeader"))?,
        temperature_channels: message.temperature_channels,
        probes: message.probes,
        probe_roles: roles.ok_or(WireError::Inconsistent("RunHeader"))?,
        calibrations: calibrations.ok_or(WireError::Inconsistent("RunHeader"))?,
        cycle_text: String::new(),
        config_text: String::new(),
        software_version: message.software_version,
        wall_start_ns: message.wall_start_ns,
        host_start: HostTime(message.host_start_ns),
    })
}

const NO_READING: &str = "no-reading";

/// Each reason by its word in a recording.
const LACKS: [(&str, Lacks); 4] =
    [("", Lacks::Unsaid), ("dwell", Lacks::Dwell), ("value", Lacks::Value), ("end", Lacks::End)];

fn word_of(lacks: Lacks) -> &'static str {
    LACKS.iter().find(|(_, own)| *own == lacks).map_or("", |(word, _)| word)
}

fn lacks_of(word: &str) -> Lacks {
    LACKS.iter().find(|(own, _)| *own == word).map_or(Lacks::Unsaid, |(_, lacks)| *lacks)
}

/// A point with its place in the order of the run.
pub fn encode_point(index: u64, point: &Point) -> Encoded {
    let state = &point.state;
    let message = pb::Point {
        index,
        time_s: state.time_s,
        setup: u32::try_from(state.setup).unwrap_or(u32::MAX),
        position_mm_rad: by_place(&state.position),
        direction: by_place(&state.direction),
        velocity_per_s: by_place(&state.velocity),
        acceleration_per_s2: by_place(&state.acceleration),
        since_reversal_mm_rad: by_place(&state.since_reversal),
        temperature_degc: state.temperature_degc.clone(),
        deflection_mm: state.deflection_mm.as_slice().to_vec(),
        reading_mm: point.reading_mm.to_vec(),
        spread_mm: point.spread_mm.to_vec(),
        samples: point.samples,
        quality: match point.quality {
            Quality::Good => "good".into(),
            Quality::Unsettled => "unsettled".into(),
            Quality::NoReading(_) => NO_READING.into(),
        },
        lacks: match point.quality {
            Quality::NoReading(lacks) => word_of(lacks).into(),
            Quality::Good | Quality::Unsettled => String::new(),
        },
        target: u32::try_from(state.target).unwrap_or(u32::MAX),
    };
    encoded(Topic::Point, state.time_s.unwrap_or(0.0), 1, &message)
}

fn point_from(m: pb::Point) -> Result<Point, WireError> {
    let point = || {
        let state = State {
            position: from_places(&m.position_mm_rad)?,
            direction: from_places(&m.direction)?,
            velocity: from_places(&m.velocity_per_s)?,
            acceleration: from_places(&m.acceleration_per_s2)?,
            since_reversal: from_places(&m.since_reversal_mm_rad)?,
            time_s: m.time_s,
            temperature_degc: m.temperature_degc.clone(),
            setup: usize::try_from(m.setup).ok()?,
            target: usize::try_from(m.target).ok()?,
            deflection_mm: Vector3::from(setup::three(&m.deflection_mm)?),
        };
        let quality = match m.quality.as_str() {
            "good" => Quality::Good,
            "unsettled" => Quality::Unsettled,
            // A word of a later version is none of ours.
            NO_READING => Quality::NoReading(lacks_of(&m.lacks)),
            _ => return None,
        };
        let (reading_mm, spread_mm) = (setup::three(&m.reading_mm)?, setup::three(&m.spread_mm)?);
        Some(Point { state, reading_mm, spread_mm, samples: m.samples, quality })
    };
    point().ok_or(WireError::Inconsistent("Point"))
}

/// A temperature.
pub fn encode_temperature(reading: &Temperature) -> Encoded {
    let channel = u32::from(reading.channel);
    let message = pb::Temperature { time_s: Some(reading.time_s), channel, value_degc: reading.value_degc };
    encoded(Topic::Temperature, reading.time_s, 1, &message)
}

/// An event.
pub fn encode_event(event: &Event) -> Encoded {
    let message =
        pb::Event { time_s: Some(event.time_s), kind: event.kind.clone(), text: event.text.clone() };
    encoded(Topic::Event, event.time_s, 1, &message)
}

/// A gap; stands where it began.
pub fn encode_gap(gap: &Gap) -> Encoded {
    let message = pb::Gap {
        source: gap.source.clone(),
        from_s: Some(gap.from_s),
        to_s: Some(gap.to_s),
        lost_samples: gap.lost_samples,
        reason: gap.reason.clone(),
    };
    let missing = gap.lost_samples.unwrap_or_default();
    Encoded { until_s: gap.to_s, missing, ..encoded(Topic::Gap, gap.from_s, 0, &message) }
}

/// A probe value for viewers.
pub fn encode_plot(sample: &ProbeSample) -> Encoded {
    let message = pb::PlotSample { value_um: convert::um_from_mm(sample.value_mm) };
    encoded(Topic::Plot(sample.channel), sample.time_s, 0, &message)
}

/// Axis positions for viewers.
pub fn encode_plot_axes(sample: &AxisSample) -> Encoded {
    let [x_mm, y_mm, z_mm, a, b, c, u_mm, v_mm, w_mm, more @ ..] = sample.position.0;
    let [a_deg, b_deg, c_deg] = [a, b, c].map(convert::deg_from_rad);
    let moved = more.iter().rposition(|rad| *rad != 0.0).map_or(0, |last| last + 1);
    let more_deg = more[..moved].iter().copied().map(convert::deg_from_rad).collect();
    let message = pb::PlotAxes { x_mm, y_mm, z_mm, a_deg, b_deg, c_deg, u_mm, v_mm, w_mm, more_deg };
    encoded(Topic::PlotAxes, sample.time_s, 0, &message)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of recordings that knew six axes.
    #[test]
    fn a_point_of_six_axes_is_read() {
        let six = |first: f64| vec![first, 0.0, 0.0, 0.0, 0.0, -0.0];
        let message = pb::Point {
            position_mm_rad: six(7.0),
            direction: six(1.0),
            velocity_per_s: six(0.0),
            acceleration_per_s2: six(0.0),
            since_reversal_mm_rad: six(3.0),
            deflection_mm: vec![0.0; 3],
            reading_mm: vec![0.0; 3],
            spread_mm: vec![0.0; 3],
            quality: "good".into(),
            ..pb::Point::default()
        };
        let point = point_from(message.clone()).unwrap();
        assert_eq!((point.state.position.0[0], point.state.since_reversal.0[0]), (7.0, 3.0));
        assert_eq!(point.state.position.0[6..], [0.0; 7]);
        for wrong in [5, 14] {
            let wrong = pb::Point { direction: vec![0.0; wrong], ..message.clone() };
            assert!(point_from(wrong).is_err());
        }
    }

    #[test]
    fn a_list_for_a_place_that_does_not_exist_is_refused() {
        let batch = |place| pb::AxisBatch {
            time_ns_delta: vec![0],
            arrival_ns_delta: vec![0],
            more: vec![pb::JointBatch { place, position_mm_rad: vec![0.25] }],
            ..pb::AxisBatch::default()
        };
        assert_eq!(axes_from(batch(12)).unwrap()[0].position.0[12], 0.25);
        for place in [5, 13] {
            assert!(axes_from(batch(place)).is_err());
        }
    }
}
