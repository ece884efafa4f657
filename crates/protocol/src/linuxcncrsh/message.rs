//! Requests and replies.

/// What is asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Who is there.
    Hello {
        /// The connection password, `EMC` unless LinuxCNC is configured with another.
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
