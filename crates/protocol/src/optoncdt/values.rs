//! What the numbers of a block mean.
//! d = (x · 102/65520 − 1)/100 · MR                    [manual §7.5.2.1, distance without mastering]
//! d distance from the start of the measuring range, mm; x raw value; MR measuring range, mm.
//! Valid for 643 ≤ x ≤ 64877; up to 65520 lie the two reserves of 1 % MR; above are error codes of 18 bits.
//! Time stamp: two 16-bit words, low then high, of 10 µs ticks (wraps after 11 h 55 min 49.67 s).
//! Counter: 18 bits, one per measurement. Exposure: 0.1 µs. Intensity: 25/16368 % (100 % at 65472).

use super::command::{Command, OutputField, Reply};
use super::stream::{Block, RawValue};
use thiserror::Error;

/// Lowest raw distance inside the measuring range.
pub const RAW_MIN: u32 = 643;
/// Highest raw distance inside the measuring range.
pub const RAW_MAX: u32 = 64_877;
/// Highest raw value that is a distance at all.
const RAW_END: u32 = 65_520;
/// One tick of the sensor's time stamp, s.
pub const TIMESTAMP_TICK_S: f64 = 1e-5;

/// Why a raw value is no distance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
pub enum DistanceError {
    /// 262075: the stream does not fit the baud rate.
    #[error("sensor error 262075: more data than the baud rate carries; raise BAUDRATE or lower MEASRATE")]
    TooMuchData,
    /// 262076: no peak in the image.
    #[error("sensor error 262076: no reflection seen")]
    NoPeak,
    /// 262077: target nearer than the measuring range.
    #[error("sensor error 262077: target before the measuring range")]
    PeakBeforeRange,
    /// 262078: target farther than the measuring range.
    #[error("sensor error 262078: target behind the measuring range")]
    PeakBehindRange,
    /// 262080: no value could be computed.
    #[error("sensor error 262080: value cannot be calculated")]
    NotCalculable,
    /// 262081: the peak is too wide.
    #[error("sensor error 262081: reflection too large")]
    PeakTooLarge,
    /// 262082: the laser is switched off.
    #[error("sensor error 262082: laser is off")]
    LaserOff,
    /// Above 65520 but not in the manual.
    #[error("sensor error {0}: not in the manual")]
    Unknown(u32),
    /// 0..643 or 64878..=65520: in the reserve outside the measuring range.
    #[error("raw distance {0} is outside the measuring range 643..=64877")]
    OutsideRange(u32),
}

impl DistanceError {
    fn of(raw: u32) -> Self {
        match raw {
            262_075 => Self::TooMuchData,
            262_076 => Self::NoPeak,
            262_077 => Self::PeakBeforeRange,
            262_078 => Self::PeakBehindRange,
            262_080 => Self::NotCalculable,
            262_081 => Self::PeakTooLarge,
            262_082 => Self::LaserOff,
            0..=RAW_END => Self::OutsideRange(raw),
            _ => Self::Unknown(raw),
        }
    }

    /// The number as transmitted, for the log.
    pub fn raw(self) -> u32 {
        match self {
            Self::TooMuchData => 262_075,
            Self::NoPeak => 262_076,
            Self::PeakBeforeRange => 262_077,
            Self::PeakBehindRange => 262_078,
            Self::NotCalculable => 262_080,
            Self::PeakTooLarge => 262_081,
            Self::LaserOff => 262_082,
            Self::Unknown(raw) | Self::OutsideRange(raw) => raw,
        }
    }
}

/// Distance from the start of the measuring range in mm; `range_mm` is the sensor's measuring range.
pub fn distance_mm(raw: RawValue, range_mm: f64) -> Result<f64, DistanceError> {
    match raw.get() {
        x @ RAW_MIN..=RAW_MAX => Ok((f64::from(x) * 102.0 / 65520.0 - 1.0) / 100.0 * range_mm),
        x => Err(DistanceError::of(x)),
    }
}

/// The raw value a sensor sends for a distance in mm; outside the measuring range the error it would report.
pub fn raw_distance(distance_mm: f64, range_mm: f64) -> RawValue {
    let x = ((distance_mm / range_mm * 100.0 + 1.0) * 65520.0 / 102.0).round();
    let code = if x.is_nan() {
        DistanceError::NotCalculable.raw()
    } else if x < 0.0 {
        DistanceError::PeakBeforeRange.raw()
    } else if x > f64::from(RAW_END) {
        DistanceError::PeakBehindRange.raw()
    } else {
        x as u32
    };
    RawValue::new(code).expect("a distance or error code has at most 18 bits")
}

/// The fields of a block in their order, from `GETOUTINFO_RS422`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    fields: Vec<OutputField>,
}

/// One block with names; what the sensor was not asked for is `None`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Measurement {
    /// Distance as sent; see [`distance_mm`].
    pub distance: Option<RawValue>,
    /// Measurement counter, 18 bits; unwrap with [`Unwrap`].
    pub counter: Option<u32>,
    /// Time stamp, 10 µs ticks, 32 bits; unwrap with [`Unwrap`].
    pub timestamp_ticks: Option<u32>,
    /// Exposure time, 0.1 µs.
    pub exposure: Option<u32>,
    /// Intensity, 25/16368 %.
    pub intensity: Option<u32>,
    /// Status word (bit 2 no peak, 5 before range, 6 behind range, 15 triggered).
    pub state: Option<u32>,
    /// Distance before calibration.
    pub raw_distance: Option<RawValue>,
}

/// A block that does not fit the layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("a block of {got} values where the sensor announced {expected}; ask GETOUTINFO_RS422 again")]
pub struct LayoutMismatch {
    /// Values the layout has.
    pub expected: usize,
    /// Values in the block.
    pub got: usize,
}

impl Layout {
    /// The layout of these fields; the two halves of the time stamp are fields of their own.
    pub fn new(fields: Vec<OutputField>) -> Self {
        Self { fields }
    }

    /// The layout that a reply to `GETOUTINFO_RS422` reports, with or without the command's name in front; `None` when it
    /// names nothing.
    pub fn from_reply(reply: &Reply) -> Option<Self> {
        let command = Command::get_output_info();
        let words = reply.lines.iter().flat_map(|line| line.split_ascii_whitespace());
        let layout = Self::from_names(words.filter(|word| *word != command.name));
        (!layout.fields.is_empty()).then_some(layout)
    }

    /// The layout in the sensor's words. A bare `TIMESTAMP` stands for its two words; a name that is not known
    /// keeps its place and is not interpreted. The manual shows no example of this reply, so the spelling of the
    /// names is that of `OUTADD_RS422` and not confirmed.
    pub fn from_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut fields = Vec::new();
        for name in names {
            match name.to_ascii_uppercase().as_str() {
                "TIMESTAMP" => fields.extend([OutputField::TimestampLow, OutputField::TimestampHigh]),
                name => fields.push(OutputField::from_name(name)),
            }
        }
        Self { fields }
    }

    /// The fields in their order.
    pub fn fields(&self) -> &[OutputField] {
        &self.fields
    }

    /// Values in a block.
    pub fn values_per_block(&self) -> usize {
        self.fields.len()
    }

    /// Names the values of a block.
    pub fn read(&self, block: &Block) -> Result<Measurement, LayoutMismatch> {
        if block.values.len() != self.fields.len() {
            return Err(LayoutMismatch { expected: self.fields.len(), got: block.values.len() });
        }
        let mut measurement = Measurement::default();
        let mut ticks = [None; 2];
        for (field, &raw) in self.fields.iter().zip(&block.values) {
            let value = Some(raw.get());
            match field {
                OutputField::Distance => measurement.distance = Some(raw),
                OutputField::RawDistance => measurement.raw_distance = Some(raw),
                OutputField::Counter => measurement.counter = value,
                OutputField::TimestampLow => ticks[0] = value,
                OutputField::TimestampHigh => ticks[1] = value,
                OutputField::Exposure => measurement.exposure = value,
                OutputField::Intensity => measurement.intensity = value,
                OutputField::State => measurement.state = value,
                OutputField::Unknown => {}
            }
        }
        if let [Some(low), Some(high)] = ticks {
            measurement.timestamp_ticks = Some(low & 0xFFFF | high << 16);
        }
        Ok(measurement)
    }

    /// The block of a measurement; fields it lacks are sent as 0, numbers too large lose their upper bits, as in
    /// the sensor.
    pub fn write(&self, measurement: &Measurement) -> Block {
        let ticks = measurement.timestamp_ticks.unwrap_or(0);
        let value = |field: &OutputField| match field {
            OutputField::Distance => measurement.distance.map_or(0, RawValue::get),
            OutputField::RawDistance => measurement.raw_distance.map_or(0, RawValue::get),
            OutputField::Counter => measurement.counter.unwrap_or(0),
            OutputField::TimestampLow => ticks & 0xFFFF,
            OutputField::TimestampHigh => ticks >> 16,
            OutputField::Exposure => measurement.exposure.unwrap_or(0),
            OutputField::Intensity => measurement.intensity.unwrap_or(0),
            OutputField::State => measurement.state.unwrap_or(0),
            OutputField::Unknown => 0,
        };
        let eighteen = |value: u32| RawValue::new(value & RawValue::MAX.get()).expect("masked to 18 bits");
        Block { values: self.fields.iter().map(|field| eighteen(value(field))).collect() }
    }
}

/// Turns a counter that wraps into one that does not: `Unwrap::new(18)` for the counter, `Unwrap::new(32)` for the
/// time stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unwrap {
    bits: u32,
    last: Option<u64>,
}

impl Unwrap {
    /// For a counter of `bits` bits, 1..=32; more are taken as 32.
    pub fn new(bits: u32) -> Self {
        Self { bits: bits.clamp(1, 32), last: None }
    }

    /// The next count of a counter that only goes forward; the first one is given back as it is. A pause must be
    /// shorter than one turn (18 bits at 4 kHz: 65 s).
    pub fn push(&mut self, raw: u32) -> u64 {
        let (mask, raw) = self.masked(raw);
        let count = self.last.map_or(raw, |last| last + (raw.wrapping_sub(last) & mask));
        self.last = Some(count);
        count
    }

    /// The count nearest to the last one, forward or back: for a device that may be reset. A pause must be
    /// shorter than half a turn (18 bits at 4 kHz: 33 s).
    pub fn push_nearest(&mut self, raw: u32) -> u64 {
        let (mask, raw) = self.masked(raw);
        let count = self.last.map_or(raw, |last| {
            let forward = raw.wrapping_sub(last) & mask;
            let back = mask + 1 - forward;
            if back < forward && back <= last { last - back } else { last + forward }
        });
        self.last = Some(count);
        count
    }

    fn masked(self, raw: u32) -> (u64, u64) {
        let mask = (1u64 << self.bits) - 1;
        (mask, u64::from(raw) & mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn raw(value: u32) -> RawValue {
        RawValue::new(value).unwrap()
    }

    /// optoNCDT 1420 manual §7.5.2.1: the range is 0..MR between 643 and 64877, so the middle is MR/2.
    #[test]
    fn the_ends_and_the_middle_of_the_range_are_the_manuals() {
        let check = |x: u32, expected_mm: f64| {
            let d = distance_mm(raw(x), 10.0).unwrap();
            assert!((d - expected_mm).abs() < 1e-3, "{x} gave {d} mm, expected {expected_mm}");
        };
        check(643, 0.0);
        check(64877, 10.0);
        check(32760, 5.0);
    }

    #[test]
    fn error_codes_keep_their_number() {
        let check = |x: u32, expected: DistanceError| {
            assert_eq!(distance_mm(raw(x), 10.0), Err(expected));
            assert_eq!(expected.raw(), x);
        };
        check(262_076, DistanceError::NoPeak);
        check(262_082, DistanceError::LaserOff);
        check(262_079, DistanceError::Unknown(262_079));
        check(65_521, DistanceError::Unknown(65_521));
        check(642, DistanceError::OutsideRange(642));
        check(64_878, DistanceError::OutsideRange(64_878));
    }

    /// Manual §7.5.2.1: t = (65536 y + x)/100 ms.
    #[test]
    fn the_time_stamp_is_two_words_low_first() {
        let layout = Layout::from_names(["DIST1", "COUNTER", "TIMESTAMP"]);
        let block = Block { values: vec![raw(1000), raw(262_143), raw(0x2345), raw(0x0001)] };
        let measurement = layout.read(&block).unwrap();
        assert_eq!(measurement.timestamp_ticks, Some(0x0001_2345));
        assert_eq!(measurement.counter, Some(262_143));
        assert_eq!(layout.write(&measurement), block);
        let short = Block { values: vec![raw(1)] };
        assert_eq!(layout.read(&short), Err(LayoutMismatch { expected: 4, got: 1 }));
    }

    #[test]
    fn a_counter_goes_on_counting_when_it_wraps() {
        let mut unwrap = Unwrap::new(18);
        let counts: Vec<u64> = [262_142, 262_143, 0, 1].into_iter().map(|raw| unwrap.push(raw)).collect();
        assert_eq!(counts, [262_142, 262_143, 262_144, 262_145]);
    }

    #[test]
    fn a_counter_that_was_set_back_goes_back() {
        let mut unwrap = Unwrap::new(18);
        let counts: Vec<u64> =
            [262_143, 1, 262_140, 10].into_iter().map(|raw| unwrap.push_nearest(raw)).collect();
        assert_eq!(counts, [262_143, 262_145, 262_140, 262_154]);
        let counts: Vec<u64> = [5, 262_143].into_iter().map(|raw| unwrap.push_nearest(raw)).collect();
        assert_eq!(counts, [262_149, 262_143]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn a_distance_comes_back_within_half_a_digit(fraction in 0.0..=1.0f64, range_mm in 10.0..500.0f64) {
            let d = distance_mm(raw_distance(fraction * range_mm, range_mm), range_mm);
            if let Ok(d) = d {
                prop_assert!((d - fraction * range_mm).abs() <= 0.5 * 1.02 * range_mm / 65520.0 * 1.001);
            } else {
                prop_assert!(!(0.0001..0.9999).contains(&fraction));
            }
        }

        #[test]
        fn unwrapping_recovers_any_forward_count(
            start in 0u64..1 << 40, steps in prop::collection::vec(0u64..1 << 18, 1..50),
        ) {
            let mut unwrap = Unwrap::new(18);
            let offset = start - unwrap.push((start & 0x3_FFFF) as u32);
            let mut count = start;
            for step in steps {
                count += step;
                prop_assert_eq!(unwrap.push((count & 0x3_FFFF) as u32) + offset, count);
            }
        }
    }
}
