//! linuxcncrsh, LinuxCNC's text interface over TCP, both sides: only the words that read.
//!
//! A request is a line, a reply is a line that begins with the word asked for in capitals (`get joint_pos` →
//! `JOINT_POS 0.000000 …`); what is refused ends in `NAK`. After `hello` the server repeats every request until
//! `set echo off`. Reading needs no `set enable`, so nothing here can move a machine. Source: man page linuxcncrsh(1) of
//! LinuxCNC 2.9 and the answers of that program.

mod lines;
mod message;
mod text;

pub use message::{Item, JointUnit, ProgramStatus, Reply, Request};

pub use lines::{LONGEST_LINE, Lines};
pub use text::{LineError, parse_reply, parse_request, write_reply, write_request};

impl JointUnit {
    /// Every unit with its word.
    pub const WORDS: [(&'static str, Self); 7] = [
        ("MM", Self::Mm),
        ("INCH", Self::Inch),
        ("CM", Self::Cm),
        ("DEG", Self::Degree),
        ("RAD", Self::Radian),
        ("GRAD", Self::Gradian),
        ("CUSTOM", Self::Custom),
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, unit)| *unit == self).map_or("", |(word, _)| word)
    }

    /// True for an angle; `None` when the unit does not show it.
    pub fn is_angle(self) -> Option<bool> {
        match self {
            Self::Mm | Self::Inch | Self::Cm => Some(false),
            Self::Degree | Self::Radian | Self::Gradian => Some(true),
            Self::Custom => None,
        }
    }

    /// Millimetres or radians in one unit; `None` when unknown.
    pub fn in_mm_or_rad(self) -> Option<f64> {
        match self {
            Self::Mm => Some(1.0),
            Self::Inch => Some(25.4),
            Self::Cm => Some(10.0),
            Self::Degree => Some(std::f64::consts::PI / 180.0),
            Self::Radian => Some(1.0),
            Self::Gradian => Some(std::f64::consts::PI / 200.0),
            Self::Custom => None,
        }
    }
}
