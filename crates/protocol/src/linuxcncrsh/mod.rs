//! linuxcncrsh, LinuxCNC's text interface over TCP, both sides: only the words that read.
//!
//! A request is a line, a reply is a line that begins with the word asked for in capitals (`get joint_pos` →
//! `JOINT_POS 0.000000 …`); what is refused ends in `NAK`. After `hello` the server repeats every request until
//! `set echo off`. Reading needs no `set enable`, so nothing here can move a machine. Source: man page linuxcncrsh(1) of
//! LinuxCNC 2.9 and the answers of that program.

mod lines;
mod text;

pub use lines::{LONGEST_LINE, Lines};
pub use text::{LineError, parse_reply, parse_request, write_reply, write_request};

/// What is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Who is there.
    Hello {
        /// The connection password, `EMC` unless LinuxCNC is told another.
        password: String,
    },
    /// Do not repeat requests.
    EchoOff,
    /// A value.
    Get(Item),
}

/// A value that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// Whether requests are repeated.
    Echo,
    /// Actual positions of the joints.
    JointPos,
    /// Their units.
    JointUnits,
    /// Whether a program runs.
    ProgramStatus,
    /// Its name.
    Program,
    /// The line it is at.
    ProgramLine,
}

impl Item {
    /// Every item with its word.
    pub const WORDS: [(&'static str, Self); 6] = [
        ("echo", Self::Echo),
        ("joint_pos", Self::JointPos),
        ("joint_units", Self::JointUnits),
        ("program_status", Self::ProgramStatus),
        ("program", Self::Program),
        ("program_line", Self::ProgramLine),
    ];

    /// True when a reply is of the kind asked for.
    pub fn is_answered_by(self, reply: &Reply) -> bool {
        match self {
            Self::Echo => matches!(reply, Reply::Echo(_)),
            Self::JointPos => matches!(reply, Reply::JointPos(_)),
            Self::JointUnits => matches!(reply, Reply::JointUnits(_)),
            Self::ProgramStatus => matches!(reply, Reply::ProgramStatus(_)),
            Self::Program => matches!(reply, Reply::Program(_)),
            Self::ProgramLine => matches!(reply, Reply::ProgramLine(_)),
        }
    }

    /// Its word.
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, item)| *item == self).map_or("", |(word, _)| word)
    }
}

/// What is answered.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// `HELLO ACK server version`.
    Hello {
        /// Name of the server.
        server: String,
        /// Version of the protocol.
        version: String,
    },
    /// `HELLO NAK`: the password is wrong.
    HelloRefused,
    /// `ECHO ON` or `OFF`.
    Echo(bool),
    /// Positions of all joints in their units.
    JointPos(Vec<f64>),
    /// Units of all joints.
    JointUnits(Vec<JointUnit>),
    /// Whether a program runs.
    ProgramStatus(ProgramStatus),
    /// Path of the open program; `None` for `NONE`.
    Program(Option<String>),
    /// The line it is at.
    ProgramLine(u32),
    /// Something else that was refused, in the server's words.
    Refused(String),
}

/// Unit of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointUnit {
    /// Millimetre.
    Mm,
    /// Inch.
    Inch,
    /// Centimetre.
    Cm,
    /// Degree.
    Degree,
    /// Radian.
    Radian,
    /// Hundredth of a right angle.
    Gradian,
    /// Anything else.
    Custom,
}

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

    /// True for an angle; `None` when the unit does not tell.
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

/// Whether a program runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProgramStatus {
    /// No.
    Idle,
    /// Yes.
    Running,
    /// It is held.
    Paused,
}

impl ProgramStatus {
    /// Every state with its word.
    pub const WORDS: [(&'static str, Self); 3] =
        [("IDLE", Self::Idle), ("RUNNING", Self::Running), ("PAUSED", Self::Paused)];

    /// Its word.
    pub fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, status)| *status == self).map_or("", |(word, _)| word)
    }
}
