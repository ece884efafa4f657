//! What the box says.

use super::value::{MOST_AMPLIFIERS, Value};
use crate::lines::{LineCounts, Lines};
use thiserror::Error;

/// A line of the box.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reply {
    /// To `M0`: the values of all amplifiers, in their order.
    All(Vec<Value>),
    /// To `SR`.
    Data {
        /// Amplifier.
        amplifier: u8,
        /// Data number.
        number: u16,
        /// The data as sent.
        text: String,
    },
    /// `ER`.
    Refused(Refusal),
}

/// Why the box refused a command.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("DL-RS1A error {number:02} to {command}: {}", self.meaning())]
pub struct Refusal {
    /// The command's two letters, as far as the box understood them.
    pub command: String,
    /// Number in the manual's list.
    pub number: u8,
}

impl Refusal {
    /// The manual's words and what to do.
    pub fn meaning(&self) -> &'static str {
        match self.number {
            0 => "it knows no such command",
            20 => "the command was too long or had no line end",
            21 => "the command has the wrong number of parameters",
            22 => "a parameter is out of its range, or this amplifier has no such data",
            29 => "bytes were damaged on the line; make baud rate and parity of box and program the same",
            65 => "there is no amplifier with this number",
            _ => "see the box's manual, \"Error numbers\"",
        }
    }
}

impl Reply {
    /// The bytes on the wire.
    pub fn encode(&self) -> Vec<u8> {
        let line = match self {
            Self::All(values) => {
                let values: Vec<String> = values.iter().map(Value::to_string).collect();
                format!("M0,{}", values.join(","))
            }
            Self::Data { amplifier, number, text } => format!("SR,{amplifier:02},{number:03},{text}"),
            Self::Refused(refusal) => format!("ER,{},{:02}", refusal.command, refusal.number),
        };
        (line + "\r\n").into_bytes()
    }

    fn parse(line: &str) -> Option<Self> {
        let (letters, rest) = line.split_once(',')?;
        match letters {
            "M0" => {
                let values: Option<Vec<Value>> = rest.split(',').map(Value::parse).collect();
                values.filter(|values| values.len() <= MOST_AMPLIFIERS).map(Self::All)
            }
            "SR" => {
                let mut fields = rest.splitn(3, ',');
                let (amplifier, number) = (number(fields.next()?, 2)?, number(fields.next()?, 3)?);
                Some(Self::Data { amplifier: amplifier as u8, number, text: fields.next()?.to_owned() })
            }
            "ER" => {
                let (command, error) = rest.split_once(',')?;
                let letters = command.len() <= 2;
                let number = number(error, 2)? as u8;
                letters.then(|| Self::Refused(Refusal { command: command.to_owned(), number }))
            }
            _ => None,
        }
    }
}

fn number(text: &str, digits: usize) -> Option<u16> {
    let right = text.len() == digits && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|_| right)
}

/// Splits the host's end of the line into replies.
#[derive(Debug, Clone, Default)]
pub struct Decoder {
    lines: Lines,
}

impl Decoder {
    /// Takes bytes as read and returns the replies they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Reply> {
        bytes.iter().filter_map(|&byte| self.lines.push(byte, Reply::parse)).collect()
    }

    /// Forgets a reply half received: what comes next is another.
    pub fn restart(&mut self) {
        self.lines.restart();
    }

    /// A reply has begun and not ended.
    pub fn is_half(&self) -> bool {
        self.lines.is_half()
    }

    /// The reply half received means nothing, however it goes on.
    pub fn spoil(&mut self) {
        self.lines.spoil();
    }

    /// What was seen and lost since the start.
    pub fn counts(&self) -> LineCounts {
        self.lines.counts()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AmplifierFaults, Command, CommandDecoder, Family};
    use super::*;

    /// DL-RS1A user's manual (GT2-70), "Sample command format structure" and "Sample error response structure".
    #[test]
    fn the_examples_of_the_manual_are_read() {
        let command = Command::Read { amplifier: 6, data: 101 };
        assert_eq!(command.encode(), *b"SR,06,101\r\n");
        assert_eq!(
            CommandDecoder::default().push(b"SR,06,101\rM0\r\nXY\r"),
            [Ok(command), Ok(Command::ReadAll), Err("XY".into())]
        );
        let refusal = Refusal { command: "SR".into(), number: 65 };
        assert_eq!(Decoder::default().push(b"ER,SR,65\r\n"), [Reply::Refused(refusal.clone())]);
        assert!(refusal.to_string().contains("no amplifier with this number"), "{refusal}");
        // IG manual, "Sample response structure".
        let data = Reply::Data { amplifier: 1, number: 134, text: "1".into() };
        assert_eq!(Decoder::default().push(b"SR,01,134,1\r\n"), [data]);
        // GT2-70 manual, footnote to data number 006: 33 is "number of units" and "overcurrent".
        let causes = AmplifierFaults::parse("00033").unwrap().causes();
        assert!(causes.len() == 2 && causes[0].contains("overcurrent") && causes[1].contains("number"));
    }

    /// Data formats of data number 000 in the three manuals.
    #[test]
    fn the_digits_of_a_value_show_the_kind_of_amplifier() {
        let check = |text: &str, family, position_mm: Option<f64>| {
            let value = Value::parse(text).unwrap();
            assert_eq!(
                (value.family, value.position_mm(), value.to_string()),
                (family, position_mm, text.into())
            );
        };
        check("+000.5000", Family::Gt2, Some(0.5));
        check("-199.9999", Family::Gt2, Some(-199.9999));
        check("+200.0000", Family::Gt2, None);
        check("-000.0001", Family::Gt2, Some(-0.0001));
        check("+005.000", Family::Gt70a, Some(5.0));
        check("-99.999", Family::Ig, Some(-99.999));
        for bad in ["", "+", "000.5000", "+0.5", "+00 .5000", "+000,5000", "+0000.5000"] {
            assert_eq!(Value::parse(bad), None, "{bad}");
        }
    }
}
