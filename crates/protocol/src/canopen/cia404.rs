//! CiA 404, measuring devices: process values, units, decimal digits, status of analogue inputs.
//! Process value of channel n: 6130h:n REAL32, 7130h:n I16, 8130h:n I24, 9130h:n I32.
//! The integers are value · 10^digits with 6132h:n digits; the unit is 6131h:n (CiA 303-2: prefix as a power of ten
//! in bits 24..31, SI numerator in 16..23, denominator in 8..15). Status 6150h:n: bit 0 not valid, 1 positive, 2
//! negative overload (WIKA MH-4-CAN, special documentation §4.2.15); overload also gives NaN or the lowest integer.

use super::objects::{ObjectKey, RawBits};
use std::fmt;

/// Profile number in the low word of 1000h.
pub const PROFILE: u16 = 404;

/// Physical unit of 6131h.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Unit {
    /// The number as read.
    pub raw: u32,
}

impl Unit {
    /// FD010000h.
    pub const MILLIMETRE: Self = Self { raw: 0xFD01_0000 };
    /// FA010000h.
    pub const MICROMETRE: Self = Self { raw: 0xFA01_0000 };
    /// 002D0000h.
    pub const CELSIUS: Self = Self { raw: 0x002D_0000 };

    /// Power of ten of the prefix, −3 for milli.
    pub fn exponent(self) -> i32 {
        i32::from((self.raw >> 24) as u8 as i8)
    }

    fn numerator(self) -> u8 {
        (self.raw >> 16) as u8
    }

    fn denominator(self) -> u8 {
        (self.raw >> 8) as u8
    }
}

/// A value in the unit this program works with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Quantity {
    /// Length, mm.
    LengthMm(f64),
    /// Temperature, °C.
    TemperatureC(f64),
    /// In a unit this program does not convert: the number belongs to `unit`.
    Other {
        /// The number.
        value: f64,
        /// The unit as read.
        unit: Unit,
    },
}

impl Unit {
    /// The number, given in this unit, as a quantity.
    pub fn quantity(self, value: f64) -> Quantity {
        let si = value * 10f64.powi(self.exponent());
        match (self.numerator(), self.denominator()) {
            (0x01, 0) => Quantity::LengthMm(value * 10f64.powi(self.exponent() + 3)),
            (0x05, 0) => Quantity::TemperatureC(si - 273.15),
            (0x2D, 0) => Quantity::TemperatureC(si),
            _ => Quantity::Other { value, unit: self },
        }
    }
}

/// Type of a process value, from its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ProcessValue {
    /// 6130h, REAL32, in the unit itself.
    Real32,
    /// 7130h, in 10^−digits of the unit.
    Integer16,
    /// 8130h, in 10^−digits of the unit.
    Integer24,
    /// 9130h, in 10^−digits of the unit.
    Integer32,
}

impl ProcessValue {
    /// The type of an object that is a process value.
    pub fn of(index: u16) -> Option<Self> {
        Some(match index {
            0x6130 => Self::Real32,
            0x7130 => Self::Integer16,
            0x8130 => Self::Integer24,
            0x9130 => Self::Integer32,
            _ => return None,
        })
    }

    fn bits(self) -> u8 {
        match self {
            Self::Integer16 => 16,
            Self::Integer24 => 24,
            Self::Real32 | Self::Integer32 => 32,
        }
    }

    /// The number in its unit; `None` when the node marks it as no value (NaN, infinite, or the lowest integer), or
    /// when it has not the bits of its type.
    pub fn number(self, raw: RawBits, digits: u8) -> Option<f64> {
        if raw.bits() != self.bits() {
            return None;
        }
        match self {
            Self::Real32 => raw.real32().filter(|value| value.is_finite()).map(f64::from),
            _ => {
                let lowest = -(1i64 << (self.bits() - 1));
                (raw.signed() != lowest).then(|| raw.signed() as f64 / 10f64.powi(i32::from(digits)))
            }
        }
    }

    /// The bits of a number in its unit, rounded; outside the range the lowest integer, as a node sends at overload.
    pub fn bits_of(self, value: f64, digits: u8) -> RawBits {
        let bits = self.bits();
        if self == Self::Real32 {
            return RawBits::new(u64::from((value as f32).to_bits()), bits);
        }
        let lowest = -(1i64 << (bits - 1));
        let scaled = (value * 10f64.powi(i32::from(digits))).round();
        let fits = scaled > lowest as f64 && scaled < -(lowest as f64);
        RawBits::new((if fits { scaled as i64 } else { lowest }) as u64, bits)
    }
}

/// 6131h of a channel.
pub const fn unit_key(channel: u8) -> ObjectKey {
    ObjectKey::new(0x6131, channel)
}

/// 6132h of a channel.
pub const fn digits_key(channel: u8) -> ObjectKey {
    ObjectKey::new(0x6132, channel)
}

/// Index of the status of a channel.
pub const STATUS_INDEX: u16 = 0x6150;

/// Status 6150h of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InputStatus(pub u8);

impl InputStatus {
    /// No bit is set.
    pub fn is_good(self) -> bool {
        self.0 == 0
    }

    /// Bit 0: the value is not valid.
    pub fn is_invalid(self) -> bool {
        self.0 & 1 != 0
    }

    /// Bit 1: above the range.
    pub fn is_positive_overload(self) -> bool {
        self.0 & 2 != 0
    }

    /// Bit 2: below the range.
    pub fn is_negative_overload(self) -> bool {
        self.0 & 4 != 0
    }
}

impl fmt::Display for InputStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let meaning = match self {
            status if status.is_positive_overload() => "above the measuring range",
            status if status.is_negative_overload() => "below the measuring range",
            status if status.is_invalid() => "not valid",
            status if status.is_good() => "good",
            _ => "in a state of its maker's own, see its manual",
        };
        write!(f, "{meaning} (status {STATUS_INDEX:04X}h = {:02X}h)", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn millimetres(unit: Unit, value: f64) -> f64 {
        match unit.quantity(value) {
            Quantity::LengthMm(mm) => mm,
            other => panic!("{other:?} is no length"),
        }
    }

    #[test]
    fn units_become_millimetres_and_degrees() {
        assert_eq!(millimetres(Unit::MILLIMETRE, 1.5), 1.5);
        assert!((millimetres(Unit::MICROMETRE, 1.5) - 0.0015).abs() < 1e-18);
        assert_eq!(millimetres(Unit { raw: 0x0001_0000 }, 2.0), 2000.0);
        assert_eq!(Unit::CELSIUS.quantity(20.5), Quantity::TemperatureC(20.5));
        let bar = Unit { raw: 0x004E_0000 };
        assert_eq!(bar.quantity(3.0), Quantity::Other { value: 3.0, unit: bar });
    }

    /// 9130h with digits 4 in mm counts 0.1 µm (reference probe).
    #[test]
    fn digits_place_the_decimal_point() {
        let check = |kind: ProcessValue, raw: RawBits, digits: u8, expected: Option<f64>| {
            assert_eq!(kind.number(raw, digits), expected);
            if let Some(value) = expected {
                assert_eq!(kind.bits_of(value, digits), raw);
            }
        };
        check(ProcessValue::Integer32, RawBits::new(-5000i64 as u64, 32), 4, Some(-0.5));
        check(ProcessValue::Integer24, RawBits::new(0xFF_FFFF, 24), 0, Some(-1.0));
        check(ProcessValue::Integer16, RawBits::new(123, 16), 1, Some(12.3));
        check(ProcessValue::Real32, RawBits::new(u64::from(0.25f32.to_bits()), 32), 4, Some(0.25));
        check(ProcessValue::Integer16, RawBits::new(123, 8), 1, None);
    }

    /// WIKA MH-4-CAN §4.2.15: NaN, −32768 and −2147483648 at overload.
    #[test]
    fn overload_is_no_value() {
        assert_eq!(ProcessValue::Real32.number(RawBits::new(u64::from(f32::NAN.to_bits()), 32), 0), None);
        assert_eq!(ProcessValue::Integer16.number(RawBits::new(0x8000, 16), 3), None);
        assert_eq!(ProcessValue::Integer32.number(RawBits::new(0x8000_0000, 32), 3), None);
        assert_eq!(ProcessValue::Integer16.bits_of(40.0, 3), RawBits::new(0x8000, 16));
        let status = InputStatus(0b011);
        assert!(status.is_invalid() && status.is_positive_overload() && !status.is_negative_overload());
        assert_eq!(status.to_string(), "above the measuring range (status 6150h = 03h)");
    }
}
