//! What the host says.

use crate::lines::{LineCounts, Lines};

/// A command of the host. Writing commands (`SW`, `AW`) are left out on purpose: nothing here changes a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// `M0`: the values of all amplifiers.
    ReadAll,
    /// `SR,ii,nnn`: one data number of one amplifier.
    Read {
        /// Amplifier, 0 for the main unit.
        amplifier: u8,
        /// Data number.
        data: u16,
    },
}

impl Command {
    /// The command on one line, without line end.
    pub fn text(self) -> String {
        match self {
            Self::ReadAll => "M0".into(),
            Self::Read { amplifier, data } => format!("SR,{amplifier:02},{data:03}"),
        }
    }

    /// The bytes on the wire.
    pub fn encode(self) -> Vec<u8> {
        (self.text() + "\r\n").into_bytes()
    }

    fn parse(line: &str) -> Option<Self> {
        if line == "M0" {
            return Some(Self::ReadAll);
        }
        let (amplifier, data) = line.strip_prefix("SR,")?.split_once(',')?;
        let digits = |text: &str, count| text.len() == count && text.bytes().all(|b| b.is_ascii_digit());
        if !digits(amplifier, 2) || !digits(data, 3) {
            return None;
        }
        Some(Self::Read { amplifier: amplifier.parse().ok()?, data: data.parse().ok()? })
    }
}

/// Splits the box's end of the line into commands; a line that is none gives its first two letters.
#[derive(Debug, Clone, Default)]
pub struct CommandDecoder {
    lines: Lines,
}

impl CommandDecoder {
    /// Takes bytes as read and returns the commands they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Result<Command, String>> {
        let parse = |line: &str| Some(Command::parse(line).ok_or_else(|| line.chars().take(2).collect()));
        bytes.iter().filter_map(|&byte| self.lines.push(byte, parse)).collect()
    }

    /// What was dropped since the start.
    pub fn counts(&self) -> LineCounts {
        self.lines.counts()
    }
}
