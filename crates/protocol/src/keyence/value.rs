//! What the numbers mean.

use std::fmt;

/// Amplifiers one box can have.
pub const MOST_AMPLIFIERS: usize = 15;
/// Data number of an amplifier's error state.
pub const ERROR_STATE: u16 = 6;

/// Kind of amplifier, reported by the digits of its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// GT2-70: `±***.****`.
    Gt2,
    /// GT-70A: `±***.***`.
    Gt70a,
    /// IG: `±**.***`.
    Ig,
}

impl Family {
    const ALL: [Self; 3] = [Self::Gt2, Self::Gt70a, Self::Ig];

    /// Name of the series.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gt2 => "GT2-70",
            Self::Gt70a => "GT-70A",
            Self::Ig => "IG",
        }
    }

    /// Digits in front of and behind the point.
    fn digits(self) -> (usize, usize) {
        match self {
            Self::Gt2 => (3, 4),
            Self::Gt70a => (3, 3),
            Self::Ig => (2, 3),
        }
    }

    /// Smallest and largest number that is a position, in last digits.
    fn positions(self) -> (i64, i64) {
        match self {
            Self::Gt2 => (-1_999_999, 1_999_999),
            Self::Gt70a => (-99_999, 999_999),
            Self::Ig => (-99_999, 99_999),
        }
    }
}

/// A value as sent: a number of last digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Value {
    /// Kind of amplifier.
    pub family: Family,
    /// The number without its point.
    pub digits: i64,
}

impl Value {
    /// Position, mm; `None` when the number is a state of the amplifier.
    pub fn position_mm(self) -> Option<f64> {
        let (low, high) = self.family.positions();
        let scale = 10f64.powi(self.family.digits().1 as i32);
        (low..=high).contains(&self.digits).then(|| self.digits as f64 / scale)
    }

    /// The value nearest to a position.
    pub fn of_position_mm(family: Family, position_mm: f64) -> Self {
        let (low, high) = family.positions();
        let scale = 10f64.powi(family.digits().1 as i32);
        Self { family, digits: ((position_mm * scale).round() as i64).clamp(low, high) }
    }

    pub(super) fn parse(text: &str) -> Option<Self> {
        let (sign, number) = text.split_at_checked(1)?;
        let (whole, fraction) = number.split_once('.')?;
        let family =
            Family::ALL.into_iter().find(|family| family.digits() == (whole.len(), fraction.len()))?;
        let all_digits = whole.bytes().chain(fraction.bytes()).all(|byte| byte.is_ascii_digit());
        let magnitude: i64 = format!("{whole}{fraction}").parse().ok().filter(|_| all_digits)?;
        match sign {
            "+" => Some(Self { family, digits: magnitude }),
            "-" => Some(Self { family, digits: -magnitude }),
            _ => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, fraction) = self.family.digits();
        let scale = 10u64.pow(fraction as u32);
        let magnitude = self.digits.unsigned_abs();
        let sign = if self.digits < 0 { '-' } else { '+' };
        write!(f, "{sign}{:0whole$}.{:0fraction$}", magnitude / scale, magnitude % scale)
    }
}

/// Error state of an amplifier (data number 006): one bit for each cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AmplifierFaults(pub u16);

impl AmplifierFaults {
    const CAUSES: [&'static str; 7] = [
        "overcurrent at the outputs",
        "no signal from the head: check its cable and that it is the head of this amplifier",
        "memory of the amplifier damaged",
        "core alarm: the head was moved too fast or is damaged",
        "self-timing delay",
        "number of amplifiers differs from the setting",
        "calculation cannot be done",
    ];

    /// Reads the five digits.
    pub fn parse(data: &str) -> Option<Self> {
        let digits = data.len() == 5 && data.bytes().all(|byte| byte.is_ascii_digit());
        data.parse().ok().filter(|_| digits).map(Self)
    }

    /// The causes in words; empty when there are none.
    pub fn causes(self) -> Vec<String> {
        let named = Self::CAUSES.iter().enumerate().filter(|(bit, _)| self.0 >> bit & 1 == 1);
        let mut causes: Vec<String> = named.map(|(_, cause)| (*cause).to_owned()).collect();
        if self.0 >> Self::CAUSES.len() != 0 {
            causes.push(format!("error state {:05}, see the amplifier's manual", self.0));
        }
        causes
    }
}
