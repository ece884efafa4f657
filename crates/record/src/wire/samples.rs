//! Batches of probe values and axis positions as protobuf messages and back.

use super::message::{Encoded, Topic, WireError, encoded};
use crate::lossless::Line;
use crate::{lossless, schema as pb};
use prost::Message;
use trunnion_core::{AxisSample, AxisValues, ProbeSample, Slot, Stamp};

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
    encoded_batch(Topic::Probe(channel), &times, &message)
}

pub(super) fn probes_from(message: pb::ProbeBatch) -> Result<Vec<ProbeSample>, WireError> {
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

fn encoded_batch(topic: Topic, times: &[f64], message: &impl Message) -> Encoded {
    let until_s = times.iter().copied().fold(times[0], f64::max);
    Encoded { until_s, ..encoded(topic, times[0], times.len(), message) }
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
    encoded_batch(Topic::Axes, &times, &message)
}

pub(super) fn axes_from(m: pb::AxisBatch) -> Result<Vec<AxisSample>, WireError> {
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

/// Values by place: all with a place of their own in `AxisBatch`, then up to the last that is not zero.
pub(super) fn by_place(values: &AxisValues<f64>) -> Vec<f64> {
    let last = values.0.iter().rposition(|value| value.to_bits() != 0).map_or(0, |last| last + 1);
    values.0[..last.max(NAMED)].to_vec()
}

pub(super) fn from_places(list: &[f64]) -> Option<AxisValues<f64>> {
    let mut values = AxisValues::default();
    values.0.get_mut(..list.len()).filter(|_| list.len() >= NAMED)?.copy_from_slice(list);
    Some(values)
}
