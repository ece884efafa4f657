//! What a preset is.

use super::decoder::{Format, Unit};
use super::pattern::Pattern;

/// When a device takes the value it sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stamp {
    /// Within a millisecond of the request.
    Request,
    /// Somewhere between the request and the beginning of the answer.
    Between,
    /// Before it sends, on its own.
    Arrival,
}

/// One kind of indicator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Name in files.
    pub name: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Where the format is printed.
    pub source: &'static str,
    /// What no manual at hand confirms; empty when everything is.
    pub unconfirmed: &'static str,
    /// What the host sends for one value; empty when the device talks on its own.
    pub request: &'static str,
    /// Pattern of a line with a value.
    pub pattern: &'static str,
    /// What the number counts when the line does not say it.
    pub unit: Unit,
    /// Lines printed in the manual, without their ends, and the value that each says; empty when no manual at hand prints one.
    pub printed: &'static [(&'static str, &'static str, Unit)],
    /// Words instead of a value, and what they mean.
    pub errors: &'static [(&'static str, &'static str)],
    /// Line speed, bit/s.
    pub baud: u32,
    /// Framing by its usual name.
    pub framing: &'static str,
    /// When the value is taken.
    pub stamp: Stamp,
    /// Time between two requests, ms.
    pub poll_ms: f64,
    /// True when the request is known to change nothing on any device, so that it may be sent to find one.
    pub may_be_asked: bool,
    /// A question that changes nothing and is answered with a name, and what the name begins with; empty when there is none.
    pub identity: (&'static str, &'static [&'static str]),
    /// A value as the device would write it, for examples and simulated devices: characters, decimals, sign always.
    pub width: usize,
    /// Digits behind the point.
    pub decimals: usize,
}

impl Preset {
    /// How it says its value.
    pub fn format(&self) -> Format {
        let pattern: Pattern = self.pattern.parse().expect("a test reads every pattern of the table");
        let errors = self.errors.iter().map(|(word, meaning)| ((*word).into(), (*meaning).into())).collect();
        Format {
            pattern,
            unit: self.unit,
            errors,
            seven_bits: self.framing.starts_with('7'),
            request: self.request.as_bytes().to_vec(),
        }
    }

    /// The line, without its end, that the device sends for a number in its unit.
    pub fn line(&self, number: f64) -> String {
        let Self { width, decimals, .. } = *self;
        let value = format!("{number:+0width$.decimals$}");
        self.format()
            .pattern
            .write(&value, if self.pattern.contains("{unit}") { self.unit_word() } else { "" })
    }

    /// A blank stands for millimetres with Heidenhain; others write the word.
    fn unit_word(&self) -> &'static str {
        if self.name.starts_with("heidenhain") { "" } else { self.unit.name() }
    }
}
