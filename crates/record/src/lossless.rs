//! Doubles as small integers, without losing a bit.
//!
//! A time is near a whole nanosecond and a value near `offset + gain·raw`; what is left over is counted in
//! steps between neighbouring doubles. Most leftovers are zero or tiny, so they cost a byte or nothing.

/// Neighbouring doubles have neighbouring ranks; every bit pattern has its own.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

fn from_rank(rank: i64) -> f64 {
    f64::from_bits((rank ^ ((rank >> 63) as u64 >> 1) as i64) as u64)
}

fn steps(from: f64, to: f64) -> i64 {
    rank(to).wrapping_sub(rank(from))
}

fn step(from: f64, steps: i64) -> f64 {
    from_rank(rank(from).wrapping_add(steps))
}

/// Differences of neighbours; the first is the difference from zero.
pub fn deltas(values: impl Iterator<Item = i64>) -> Vec<i64> {
    let mut last = 0_i64;
    values.map(|value| value.wrapping_sub(std::mem::replace(&mut last, value))).collect()
}

/// Undoes [`deltas`].
pub fn sums(deltas: &[i64]) -> impl Iterator<Item = i64> {
    deltas.iter().scan(0_i64, |sum, delta| {
        *sum = sum.wrapping_add(*delta);
        Some(*sum)
    })
}

/// Times in s as differences in ns, and the leftover steps (empty when all are zero).
pub fn encode_times(times_s: &[f64]) -> (Vec<i64>, Vec<i64>) {
    let whole_ns: Vec<i64> = times_s.iter().map(|t| (t * 1e9).round() as i64).collect();
    let ulps = whole_ns.iter().zip(times_s).map(|(&ns, &t)| steps(ns as f64 * 1e-9, t)).collect();
    (deltas(whole_ns.into_iter()), empty_if_zero(ulps))
}

/// Undoes [`encode_times`]; `None` when the lists do not belong together.
pub fn decode_times(ns_deltas: &[i64], ulps: &[i64]) -> Option<Vec<f64>> {
    let ulps = fitting(ulps, ns_deltas.len())?;
    Some(sums(ns_deltas).zip(ulps).map(|(ns, ulps)| step(ns as f64 * 1e-9, ulps)).collect())
}

/// Values as a line through the raw counts.
pub struct Line {
    /// Value at raw 0.
    pub offset: f64,
    /// Value per count.
    pub gain: f64,
    /// Leftover steps; empty when all are zero or when `exact` is used.
    pub ulps: Vec<i64>,
    /// The values themselves, when the line does not shorten them.
    pub exact: Vec<f64>,
}

/// Finds the line through the samples with the smallest and the largest count.
pub fn encode_values(raw: &[i64], values: &[f64]) -> Line {
    let readable = || (0..values.len()).filter(|&i| values[i].is_finite());
    let (gain, offset) = match (readable().min_by_key(|&i| raw[i]), readable().max_by_key(|&i| raw[i])) {
        (Some(low), Some(high)) if raw[high] > raw[low] => {
            let gain = (values[high] - values[low]) / (raw[high] as f64 - raw[low] as f64);
            (gain + 0.0, values[low] - gain * raw[low] as f64 + 0.0)
        }
        (Some(only), _) => (0.0, values[only] + 0.0),
        _ => (0.0, 0.0),
    };
    let ulps: Vec<i64> =
        raw.iter().zip(values).map(|(&raw, &value)| steps(offset + gain * raw as f64, value)).collect();
    let plain_bytes = 8 * values.len();
    if ulps.iter().map(|&ulps| varint_bytes(ulps)).sum::<usize>() > plain_bytes {
        return Line { offset, gain, ulps: Vec::new(), exact: values.to_vec() };
    }
    Line { offset, gain, ulps: empty_if_zero(ulps), exact: Vec::new() }
}

/// Undoes [`encode_values`]; `None` when the lists do not belong together.
pub fn decode_values(raw: &[i64], line: &Line) -> Option<Vec<f64>> {
    if !line.exact.is_empty() {
        return (line.exact.len() == raw.len()).then(|| line.exact.clone());
    }
    let ulps = fitting(&line.ulps, raw.len())?;
    let predicted = raw.iter().map(|&raw| line.offset + line.gain * raw as f64);
    Some(predicted.zip(ulps).map(|(value, ulps)| step(value, ulps)).collect())
}

fn empty_if_zero(list: Vec<i64>) -> Vec<i64> {
    if list.iter().all(|&item| item == 0) { Vec::new() } else { list }
}

fn fitting(list: &[i64], len: usize) -> Option<impl Iterator<Item = i64>> {
    (list.is_empty() || list.len() == len).then(|| (0..len).map(|i| list.get(i).copied().unwrap_or(0)))
}

/// Bytes of a zigzag varint.
fn varint_bytes(value: i64) -> usize {
    let zigzag = ((value << 1) ^ (value >> 63)) as u64;
    (64 - zigzag.leading_zeros() as usize).div_ceil(7).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_bit_pattern_survives(
            bits in proptest::collection::vec((any::<i64>(), any::<u64>(), any::<u64>()), 0..40),
        ) {
            let raw: Vec<i64> = bits.iter().map(|b| b.0).collect();
            let values: Vec<f64> = bits.iter().map(|b| f64::from_bits(b.1)).collect();
            let times: Vec<f64> = bits.iter().map(|b| f64::from_bits(b.2)).collect();
            let same = |a: &[f64], b: &[f64]| a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()));
            let (ns, ulps) = encode_times(&times);
            prop_assert!(same(&decode_times(&ns, &ulps).unwrap(), &times));
            prop_assert!(same(&decode_values(&raw, &encode_values(&raw, &values)).unwrap(), &values));
            prop_assert!(sums(&deltas(raw.iter().copied())).eq(raw.iter().copied()));
        }
    }

    #[test]
    fn a_linear_sensor_costs_a_byte_a_value_and_signed_zero_and_nan_stay() {
        let raw: Vec<i64> = (0..200).map(|i| 130_000 + 7 * (i % 23)).collect();
        let values: Vec<f64> = raw.iter().map(|&r| (r as f64 * 1.02 / 65520.0 - 0.01) * 2.0).collect();
        let line = encode_values(&raw, &values);
        assert!(line.exact.is_empty() && line.ulps.iter().all(|u| u.abs() < 64));
        let odd = [f64::NAN, -0.0, 1.5];
        let back = decode_values(&[1, 2, 3], &encode_values(&[1, 2, 3], &odd)).unwrap();
        assert!(back[0].is_nan() && back[1].is_sign_negative() && back[2] == 1.5);
    }
}
