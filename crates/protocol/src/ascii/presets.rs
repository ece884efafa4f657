//! The kinds of indicators known by name: one entry each.

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
    /// The preset of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

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

const OPTO_RS: &[(&str, &str)] = &[
    ("ERR0", "the gauge lost its count: moved too fast, or its scale is dirty; reset it"),
    ("ERR1", "the gauge does not know the command"),
    ("ERR2", "the gauge got a damaged byte; check the cable and the framing"),
    ("ERR3", "outside the measuring range"),
    ("ERR", "the gauge reports an error"),
];

/// Every kind known.
pub const PRESETS: [Preset; 8] = [
    Preset {
        name: "heidenhain-nd28x",
        about: "Heidenhain ND 280, ND 281, ND 287 position display",
        source: "ND 287 user's manual, \"Measured value output\"",
        unconfirmed: "",
        request: "\x02",
        pattern: "{value} {unit} *",
        unit: Unit::Millimetre,
        errors: &[("?", "the display shows a fault; clear it at the display")],
        baud: 9600,
        framing: "7E2",
        stamp: Stamp::Request,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("\x1bA0000\r", &["ND"]),
        width: 11,
        decimals: 4,
    },
    Preset {
        name: "magnescale-lt30",
        about: "Magnescale LT20A, LT30 display unit, channel A",
        source: "LT20A/LT30 instruction manual, \"The output data format\"",
        unconfirmed: "the request, line speed and framing",
        request: "R\r\n",
        pattern: "A{value} *",
        unit: Unit::Millimetre,
        errors: &[
            ("+F", "beyond the digits of the display"),
            ("-F", "beyond the digits of the display"),
            ("AE", "alarm: gauge moved too fast or not connected; reset the display"),
        ],
        baud: 9600,
        framing: "8N1",
        stamp: Stamp::Between,
        poll_ms: 50.0,
        may_be_asked: false,
        identity: ("", &[]),
        width: 8,
        decimals: 4,
    },
    Preset {
        name: "magnescale-mg80",
        about: "Magnescale MG80 unit, one channel",
        source: "",
        unconfirmed: "the request, the line, its speed and framing",
        request: "R\r\n",
        pattern: "{value}",
        unit: Unit::Millimetre,
        errors: &[("E", "the unit reports an error")],
        baud: 9600,
        framing: "8N1",
        stamp: Stamp::Between,
        poll_ms: 50.0,
        may_be_asked: false,
        identity: ("", &[]),
        width: 9,
        decimals: 4,
    },
    Preset {
        name: "mahr-c1202",
        about: "Mahr Millimar C 1202, feature 1",
        source: "Millimar C 1202 manual §7.2, \"C1202 Duplex interface\"",
        unconfirmed: "",
        request: "M1?\r",
        pattern: "# {value} {unit} *",
        unit: Unit::Millimetre,
        errors: &[
            ("ERR6", "feature 1 is switched off at the instrument"),
            ("ERR", "the instrument reports an error"),
        ],
        baud: 9600,
        framing: "7E2",
        stamp: Stamp::Between,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("DES?\r", &["1 C1202"]),
        width: 8,
        decimals: 4,
    },
    Preset {
        name: "mitutoyo-id-h",
        about: "Mitutoyo ID-H0530, ID-H0560 indicator on RS-232C",
        source: "ID-H0530/0560 user's manual No. 99MAH016B, §4.2.4",
        unconfirmed: "line speed and framing are set at the indicator",
        request: "GA00\r\n",
        pattern: "G?##,{value}",
        unit: Unit::Millimetre,
        errors: &[("ER", "the indicator reports an error")],
        baud: 9600,
        framing: "7E2",
        stamp: Stamp::Between,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("", &[]),
        width: 10,
        decimals: 4,
    },
    Preset {
        name: "mitutoyo-usb",
        about: "Mitutoyo gauge on a USB input tool, talking on its own",
        source: "QM-Height user's manual No. 99MAF600B, §6.2.2",
        unconfirmed: "the answers 911 and 912 of an input tool",
        request: "",
        pattern: "01A{value}",
        unit: Unit::Millimetre,
        errors: &[
            ("911", "no gauge at the input tool"),
            ("912", "the gauge sends what the input tool cannot read"),
        ],
        baud: 9600,
        framing: "8N1",
        stamp: Stamp::Arrival,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("", &[]),
        width: 9,
        decimals: 3,
    },
    Preset {
        name: "sylvac",
        about: "Sylvac gauge or display on Opto-RS232 (also Käfer, Bowers, Trimos)",
        source: "Sylvac \"User's manual for OPTO-RS cable connections\"",
        unconfirmed: "",
        request: "?\r",
        pattern: "{value}",
        unit: Unit::Millimetre,
        errors: OPTO_RS,
        baud: 4800,
        framing: "7E2",
        stamp: Stamp::Between,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("ID?\r", &["SY"]),
        width: 8,
        decimals: 4,
    },
    Preset {
        name: "tesa",
        about: "TESA TT80 (TT90 with unit = \"um\")",
        source: "TT80/TT90 manual §11, \"Functions accessible through the RS232 interface\"",
        unconfirmed: "",
        request: "?\r",
        pattern: "{value}",
        unit: Unit::Millimetre,
        errors: &[("ERR", "the instrument reports an error; its manual lists the number")],
        baud: 4800,
        framing: "7E2",
        stamp: Stamp::Between,
        poll_ms: 100.0,
        may_be_asked: true,
        identity: ("ID?\r", &["TE"]),
        width: 8,
        decimals: 2,
    },
];

#[cfg(test)]
mod tests {
    use super::super::decoder::{Decoder, Line, Measured};
    use super::super::pattern::Number;
    use super::*;

    fn decode(preset: &str, bytes: &[u8]) -> Vec<Line> {
        Decoder::new(Preset::named(preset).unwrap().format()).push(bytes)
    }

    fn value(digits: i64, decimals: u32, unit: Unit) -> Vec<Line> {
        vec![Line::Value(Measured { number: Number { digits, decimals }, unit })]
    }

    /// Lines printed in the manuals named in the table.
    #[test]
    fn the_lines_of_the_manuals_are_read() {
        use Unit::{Inch, Micrometre, Millimetre};
        // "Example: order of the measured value output", X = -5.23 mm, sorted (=), actual value of a series (A).
        check("heidenhain-nd28x", "-      5.23  =A\r\n", value(-523, 2, Millimetre));
        check("heidenhain-nd28x", "+    1.2345 \"  \r\n", value(12345, 4, Inch));
        check("magnescale-lt30", "A+12.3456\r\n", value(123_456, 4, Millimetre));
        check("mahr-c1202", "1 +003.25 um <\r", value(325, 2, Micrometre));
        check("mahr-c1202", "1 -000.125 mm = =\r", value(-125, 3, Millimetre));
        check("mitutoyo-id-h", "GN00,+0016.2345\r\n", value(162_345, 4, Millimetre));
        check("mitutoyo-id-h", "GM07,-0016.2345\r\n", value(-162_345, 4, Millimetre));
        check("mitutoyo-usb", "01A+0000.123\r", value(123, 3, Millimetre));
        check("mitutoyo-usb", "01A+0000.125\r", value(125, 3, Millimetre));
        check("sylvac", "+00.0000\r", value(0, 4, Millimetre));
        check("sylvac", " 0123.456\r", value(123_456, 3, Millimetre));
        check("tesa", "-1234.56\r\n", value(-123_456, 2, Millimetre));
    }

    fn check(preset: &str, line: &str, expected: Vec<Line>) {
        assert_eq!(decode(preset, line.as_bytes()), expected, "{preset} {line:?}");
    }

    #[test]
    fn what_a_device_says_instead_of_a_value_has_a_meaning() {
        let check = |preset: &str, line: &[u8], expected: &str| {
            let lines = decode(preset, line);
            let [Line::Error { index, .. }] = lines.as_slice() else { panic!("{preset} {lines:?}") };
            let meaning = Preset::named(preset).unwrap().errors[*index].1;
            assert!(meaning.contains(expected), "{preset} {meaning}");
        };
        check("sylvac", b"ERR3\r", "outside the measuring range");
        check("tesa", b"ERR23\r\n", "lists the number");
        check("mahr-c1202", b"1 ERR6\r", "switched off");
        check("magnescale-lt30", b"A+F2.3456\r\n", "beyond");
        check("magnescale-lt30", b"AE\r\n", "alarm");
        check("heidenhain-nd28x", b"+      0.00 ? \r\n", "fault");
    }

    #[test]
    fn parity_bits_echoes_and_units_that_are_no_length_do_not_become_values() {
        let with_parity =
            b"?\r+01.2345\r".map(|byte| if byte.count_ones() % 2 == 1 { byte | 0x80 } else { byte });
        assert_eq!(decode("sylvac", &with_parity), value(12345, 4, Unit::Millimetre));
        assert_eq!(decode("mahr-c1202", b"1 +012.5 deg\r"), [Line::Unit("deg".into())]);
        assert_eq!(decode("sylvac", b"01A+0000.123\r"), [Line::Strange("01A+0000.123".into())]);
    }

    #[test]
    fn every_preset_reads_the_lines_it_writes() {
        assert!(PRESETS.is_sorted_by_key(|preset| preset.name));
        for preset in PRESETS {
            let line = preset.line(-1.5) + "\r\n";
            let lines = Decoder::new(preset.format()).push(line.as_bytes());
            let [Line::Value(measured)] = lines.as_slice() else {
                panic!("{} {line:?} {lines:?}", preset.name)
            };
            assert_eq!((measured.number.value(), measured.unit), (-1.5, preset.unit), "{}", preset.name);
            assert!(!preset.source.is_empty() || !preset.unconfirmed.is_empty());
        }
    }
}
