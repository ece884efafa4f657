//! Items as protobuf messages and back.

mod setup;

use crate::item::{Item, RunHeader, Temperature};
use crate::lossless::Line;
use crate::{lossless, schema as pb};
use nalgebra::Vector3;
use prost::{DecodeError, Message};
use trunnion_core::{
    AxisSample, AxisValues, Event, Gap, HostTime, Point, ProbeSample, Quality, Role, Setup, Slot, Stamp,
    State, convert,
};
use trunnion_cycles::RunKind;

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
    /// How many samples are lost with it.
    pub samples: u64,
    pub payload: Vec<u8>,
}

fn encoded(topic: Topic, time_s: f64, samples: usize, message: &impl Message) -> Encoded {
    Encoded { topic, time_s, samples: samples as u64, payload: message.encode_to_vec() }
}

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

/// Why a message cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum WireError {
    #[error(transparent)]
    Protobuf(#[from] DecodeError),
    #[error("a {0} contradicts itself")]
    Inconsistent(&'static str),
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
        cycle_text: String::new(),
        config_text: String::new(),
        software_version: message.software_version,
        wall_start_ns: message.wall_start_ns,
        host_start: HostTime(message.host_start_ns),
    })
}

/// Samples of one clock can share a batch.
pub fn same_clock(a: &Stamp, b: &Stamp) -> bool {
    a.epoch == b.epoch && a.tick_s == b.tick_s && a.arrival_s.is_nan() == b.arrival_s.is_nan()
}

/// Arrivals as differences in ns; empty when they are not known.
fn encode_arrivals<'s>(stamps: impl Iterator<Item = &'s Stamp> + Clone) -> Vec<i64> {
    if stamps.clone().any(|stamp| stamp.arrival_s.is_nan()) {
        return Vec::new();
    }
    lossless::deltas(stamps.map(|stamp| (stamp.arrival_s * 1e9).round() as i64))
}

/// Undoes [`encode_arrivals`]; `None` when the lists do not belong together.
fn decode_arrivals(deltas: &[i64], len: usize) -> Option<Vec<f64>> {
    match deltas.len() {
        0 => Some(vec![f64::NAN; len]),
        found => (found == len).then(|| lossless::sums(deltas).map(|ns| ns as f64 * 1e-9).collect()),
    }
}

/// One batch of one probe channel on one clock. `samples` is not empty.
pub fn encode_probes(channel: u16, samples: &[ProbeSample]) -> Encoded {
    let raw: Vec<i64> = samples.iter().map(|sample| sample.raw).collect();
    let values: Vec<f64> = samples.iter().map(|sample| sample.value_mm).collect();
    let times: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
    let line = lossless::encode_values(&raw, &values);
    let (time_ns_delta, time_ulps) = lossless::encode_times(&times);
    let message = pb::ProbeBatch {
        channel: u32::from(channel),
        time_ns_delta,
        time_ulps,
        device_ticks_delta: lossless::deltas(samples.iter().map(|sample| sample.stamp.ticks as i64)),
        raw_delta: lossless::deltas(raw.into_iter()),
        value_offset_mm: line.offset,
        value_gain_mm: line.gain,
        value_ulps: line.ulps,
        value_mm: line.exact,
        arrival_ns_delta: encode_arrivals(samples.iter().map(|sample| &sample.stamp)),
        epoch: samples[0].stamp.epoch,
        tick_s: samples[0].stamp.tick_s,
    };
    encoded(Topic::Probe(channel), times[0], samples.len(), &message)
}

fn probes_from(message: pb::ProbeBatch) -> Result<Vec<ProbeSample>, WireError> {
    let wrong = || WireError::Inconsistent("ProbeBatch");
    let channel = u16::try_from(message.channel).map_err(|_| wrong())?;
    let raw: Vec<i64> = lossless::sums(&message.raw_delta).collect();
    let times = lossless::decode_times(&message.time_ns_delta, &message.time_ulps).ok_or_else(wrong)?;
    let line = Line {
        offset: message.value_offset_mm,
        gain: message.value_gain_mm,
        ulps: message.value_ulps,
        exact: message.value_mm,
    };
    let values = lossless::decode_values(&raw, &line).ok_or_else(wrong)?;
    let ticks: Vec<i64> = lossless::sums(&message.device_ticks_delta).collect();
    if times.len() != raw.len() || ticks.len() != raw.len() {
        return Err(wrong());
    }
    let arrivals = decode_arrivals(&message.arrival_ns_delta, raw.len()).ok_or_else(wrong)?;
    let (epoch, tick_s) = (message.epoch, message.tick_s);
    let sample = |i: usize| ProbeSample {
        channel,
        time_s: times[i],
        stamp: Stamp { epoch, ticks: ticks[i] as u64, tick_s, arrival_s: arrivals[i] },
        raw: raw[i],
        value_mm: values[i],
    };
    Ok((0..raw.len()).map(sample).collect())
}

/// Stamps of axis positions are in ns.
const AXIS_TICK_S: f64 = 1e-9;

/// Places with a list of their own in `AxisBatch`: X Y Z A B C.
const NAMED: usize = 6;

/// One batch of axis positions on one clock. `samples` is not empty.
pub fn encode_axes(samples: &[AxisSample]) -> Encoded {
    let times: Vec<f64> = samples.iter().map(|sample| sample.time_s).collect();
    let (time_ns_delta, time_ulps) = lossless::encode_times(&times);
    let positions = |slot: Slot| -> Vec<f64> {
        let moved = samples.iter().any(|sample| sample.position[slot].to_bits() != 0);
        if moved { samples.iter().map(|sample| sample.position[slot]).collect() } else { Vec::new() }
    };
    let more = Slot::ALL[NAMED..].iter().filter_map(|&slot| {
        let position_mm_rad = positions(slot);
        let place = slot.index() as u32;
        (!position_mm_rad.is_empty()).then_some(pb::JointBatch { place, position_mm_rad })
    });
    let message = pb::AxisBatch {
        time_ns_delta,
        time_ulps,
        x_mm: positions(Slot::ALL[0]),
        y_mm: positions(Slot::ALL[1]),
        z_mm: positions(Slot::ALL[2]),
        a_rad: positions(Slot::ALL[3]),
        b_rad: positions(Slot::ALL[4]),
        c_rad: positions(Slot::ALL[5]),
        more: more.collect(),
        stamp_ns_delta: if samples.iter().any(|sample| sample.stamp.ticks != 0) {
            lossless::deltas(samples.iter().map(|sample| sample.stamp.ticks as i64))
        } else {
            Vec::new()
        },
        arrival_ns_delta: encode_arrivals(samples.iter().map(|sample| &sample.stamp)),
        epoch: samples[0].stamp.epoch,
        held: if samples.iter().any(|sample| sample.held) {
            samples.iter().map(|sample| sample.held).collect()
        } else {
            Vec::new()
        },
        skew_ns_delta: if samples.iter().any(|sample| sample.skew_s != 0.0) {
            lossless::deltas(samples.iter().map(|sample| (sample.skew_s * 1e9).round() as i64))
        } else {
            Vec::new()
        },
    };
    encoded(Topic::Axes, times[0], samples.len(), &message)
}

fn axes_from(m: pb::AxisBatch) -> Result<Vec<AxisSample>, WireError> {
    let wrong = || WireError::Inconsistent("AxisBatch");
    let times = lossless::decode_times(&m.time_ns_delta, &m.time_ulps).ok_or_else(wrong)?;
    let mut lists: AxisValues<Vec<f64>> = AxisValues::default();
    for (list, named) in lists.0.iter_mut().zip([m.x_mm, m.y_mm, m.z_mm, m.a_rad, m.b_rad, m.c_rad]) {
        *list = named;
    }
    for joint in m.more {
        let place = usize::try_from(joint.place).ok().filter(|place| *place >= NAMED);
        *place.and_then(|place| lists.0.get_mut(place)).ok_or_else(wrong)? = joint.position_mm_rad;
    }
    if lists.0.iter().any(|list| !list.is_empty() && list.len() != times.len()) {
        return Err(wrong());
    }
    let fits = |len: usize| len == 0 || len == times.len();
    if !(fits(m.stamp_ns_delta.len()) && fits(m.held.len()) && fits(m.skew_ns_delta.len())) {
        return Err(wrong());
    }
    let arrivals = decode_arrivals(&m.arrival_ns_delta, times.len()).ok_or_else(wrong)?;
    let stamps: Vec<i64> = lossless::sums(&m.stamp_ns_delta).collect();
    let skews: Vec<i64> = lossless::sums(&m.skew_ns_delta).collect();
    let tick_s = if stamps.is_empty() { 0.0 } else { AXIS_TICK_S };
    let sample = |i: usize| AxisSample {
        time_s: times[i],
        stamp: Stamp {
            epoch: m.epoch,
            ticks: stamps.get(i).map_or(0, |&stamp| stamp as u64),
            tick_s,
            arrival_s: arrivals[i],
        },
        held: m.held.get(i).copied().unwrap_or(false),
        skew_s: skews.get(i).map_or(0.0, |&skew| skew as f64 * 1e-9),
        position: AxisValues::from_fn(|letter| lists[letter].get(i).copied().unwrap_or(0.0)),
    };
    Ok((0..times.len()).map(sample).collect())
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
            Quality::NoReading => "no-reading".into(),
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
            "no-reading" => Quality::NoReading,
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
    encoded(Topic::Gap, gap.from_s, 1, &message)
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

/// Values by place: all with a place of their own in `AxisBatch`, then up to the last that is not zero.
fn by_place(values: &AxisValues<f64>) -> Vec<f64> {
    let last = values.0.iter().rposition(|value| value.to_bits() != 0).map_or(0, |last| last + 1);
    values.0[..last.max(NAMED)].to_vec()
}

fn from_places(list: &[f64]) -> Option<AxisValues<f64>> {
    let mut values = AxisValues::default();
    values.0.get_mut(..list.len()).filter(|_| list.len() >= NAMED)?.copy_from_slice(list);
    Some(values)
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
