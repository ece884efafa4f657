//! Bytes into values.

use super::pattern::{Number, Pattern};
use crate::lines::{LineCounts, Lines};

/// Start of text: some devices put it before a line.
const STX: u8 = 0x02;

/// What the number counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Millimetres.
    Millimetre,
    /// Micrometres.
    Micrometre,
    /// Inches.
    Inch,
    /// Degrees Celsius.
    Celsius,
}

impl Unit {
    /// Every unit with its name in files.
    pub const NAMES: [(&'static str, Self); 4] =
        [("mm", Self::Millimetre), ("um", Self::Micrometre), ("inch", Self::Inch), ("degC", Self::Celsius)];

    /// Name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, unit)| *unit == self).map_or("mm", |(name, _)| name)
    }

    /// The unit a device writes behind its number; nothing is written by most.
    fn of_word(word: &str, usual: Self) -> Option<Self> {
        match word {
            "" => Some(usual),
            "mm" | "MM" => Some(Self::Millimetre),
            "um" | "UM" => Some(Self::Micrometre),
            "in" | "IN" | "inch" | "\"" => Some(Self::Inch),
            "degC" | "C" => Some(Self::Celsius),
            _ => None,
        }
    }

    /// Millimetres of one unit; `None` for a temperature.
    pub fn length_mm(self) -> Option<f64> {
        match self {
            Self::Millimetre => Some(1.0),
            Self::Micrometre => Some(1e-3),
            Self::Inch => Some(25.4),
            Self::Celsius => None,
        }
    }
}

/// How a device says its value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Format {
    /// What a line with a value looks like.
    pub pattern: Pattern,
    /// What the number counts when the line does not say it.
    pub unit: Unit,
    /// Words that stand in a line instead of a value, with their meaning.
    pub errors: Vec<(String, String)>,
    /// Bytes have seven bits; the eighth is parity.
    pub seven_bits: bool,
    /// What the host asks; a device may repeat it, which means nothing.
    pub request: Vec<u8>,
}

/// A number with what it counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Measured {
    /// The number as sent.
    pub number: Number,
    /// What it counts.
    pub unit: Unit,
}

/// What a line said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A value.
    Value(Measured),
    /// No value, and why.
    Error {
        /// Place in [`Format::errors`].
        index: usize,
        /// The line.
        text: String,
    },
    /// A value in a unit that is neither a length nor a temperature.
    Unit(String),
    /// Text that is none of these: perhaps another device.
    Strange(String),
}

/// Splits bytes into lines and reads them. Lines that mean nothing are counted, and given out as [`Line::Strange`]
/// when they are text.
#[derive(Debug, Clone)]
pub struct Decoder {
    format: Format,
    lines: Lines,
    strange: u64,
}

impl Decoder {
    /// For one format.
    pub fn new(format: Format) -> Self {
        Self { format, lines: Lines::default(), strange: 0 }
    }

    /// Takes bytes as read and returns what their lines say.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut lines = Vec::new();
        for &byte in bytes {
            let byte = if self.format.seven_bits { byte & 0x7F } else { byte };
            if byte == STX {
                self.lines.restart();
                continue;
            }
            let format = &self.format;
            let line = self.lines.push(byte, |text| Some(format.read(text)));
            let Some(line) = line.flatten() else { continue };
            self.strange += u64::from(matches!(line, Line::Strange(_)));
            lines.push(line);
        }
        lines
    }

    /// Forgets a line half received: what comes next is another.
    pub fn restart(&mut self) {
        self.lines.restart();
    }

    /// A line has begun and not ended.
    pub fn is_half(&self) -> bool {
        self.lines.is_half()
    }

    /// The line half received means nothing, however it goes on.
    pub fn spoil(&mut self) {
        self.lines.spoil();
    }

    /// What was seen and lost since the start; text that is no line of the format counts as bad.
    pub fn counts(&self) -> LineCounts {
        let seen = self.lines.counts();
        LineCounts { lines: seen.lines - self.strange, bad_lines: seen.bad_lines + self.strange, ..seen }
    }
}

impl Format {
    /// What a line says; `None` for an echo of the request.
    fn read(&self, text: &str) -> Option<Line> {
        let text = text.trim_end();
        let echo =
            text.bytes().eq(self.request.iter().copied().filter(|byte| !matches!(byte, b'\r' | b'\n')));
        if text.is_empty() || (echo && !self.request.is_empty()) {
            return None;
        }
        if let Some(index) = self.errors.iter().position(|(word, _)| text.contains(word.as_str())) {
            return Some(Line::Error { index, text: text.to_owned() });
        }
        Some(match self.pattern.read(text) {
            None => Line::Strange(text.to_owned()),
            Some((number, word)) => match Unit::of_word(word, self.unit) {
                Some(unit) => Line::Value(Measured { number, unit }),
                None => Line::Unit(word.to_owned()),
            },
        })
    }
}
