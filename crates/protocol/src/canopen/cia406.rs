//! CiA 406, encoders: position 6004h:00 (U32), 6008h:00 (U64), 6020h:n (I32, sensor n); speed 6030h:n (I16).
//! Linear encoders count steps: position step 6005h:01 in nm, else 6501h:00 in nm; speed step 6005h:02 in 0.01 mm/s.
//! The step of 6008h is taken to be the same [not confirmed]. Rotary encoders are given raw.

use super::objects::{ObjectKey, RawBits};

/// Profile number in the low word of 1000h.
pub const PROFILE: u16 = 406;

/// True when the high word of 1000h names a linear encoder (6..=9) or a multi-sensor interface (10).
pub fn is_linear(device_type: u32) -> bool {
    (6..=10).contains(&(device_type >> 16))
}

/// What an object of the profile holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EncoderValue {
    /// 6004h and 6008h, unsigned steps.
    Position,
    /// 6020h, signed steps of one sensor.
    SensorPosition,
    /// 6030h, signed speed steps of one sensor.
    Speed,
}

impl EncoderValue {
    /// What the object at `index` holds.
    pub fn of(index: u16) -> Option<Self> {
        Some(match index {
            0x6004 | 0x6008 => Self::Position,
            0x6020 => Self::SensorPosition,
            0x6030 => Self::Speed,
            _ => return None,
        })
    }

    /// Counts as sent.
    pub fn counts(self, raw: RawBits) -> f64 {
        match self {
            Self::Position => raw.unsigned() as f64,
            Self::SensorPosition | Self::Speed => raw.signed() as f64,
        }
    }
}

/// 6005h:01, position step in nm.
pub const POSITION_STEP: ObjectKey = ObjectKey::new(0x6005, 1);
/// 6005h:02, speed step in 0.01 mm/s.
pub const SPEED_STEP: ObjectKey = ObjectKey::new(0x6005, 2);
/// 6501h:00, measuring step in nm.
pub const MEASURING_STEP: ObjectKey = ObjectKey::new(0x6501, 0);

/// Position in mm; `step_nm` as read.
pub fn position_mm(counts: f64, step_nm: u32) -> f64 {
    counts * f64::from(step_nm) * 1e-6
}

/// Speed in mm/s; `step` in 0.01 mm/s as read.
pub fn speed_mm_per_s(counts: f64, step: u32) -> f64 {
    counts * f64::from(step) * 0.01
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reference encoder: device type 00080196h, step 100 nm, 1 000 000 counts = 100 mm.
    #[test]
    fn steps_become_millimetres() {
        assert!(is_linear(0x0008_0196) && !is_linear(0x0002_0196));
        let counts = |index, raw| EncoderValue::of(index).map(|value: EncoderValue| value.counts(raw));
        let position = counts(0x6004, RawBits::new(1_000_000, 32)).unwrap();
        assert!((position_mm(position, 100) - 100.0).abs() < 1e-9);
        assert_eq!(counts(0x6004, RawBits::new(0xFFFF_FFFF, 32)), Some(4_294_967_295.0));
        assert_eq!(counts(0x6020, RawBits::new(0xFFFF_FFFF, 32)), Some(-1.0));
        assert_eq!(speed_mm_per_s(counts(0x6030, RawBits::new(0xFFFF, 16)).unwrap(), 10), -0.1);
        assert_eq!(counts(0x6000, RawBits::new(0, 16)), None);
    }
}
