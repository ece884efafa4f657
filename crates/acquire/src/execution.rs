//! What controllers call the states of a program, and what each means for a cycle.
//!
//! One table for each vocabulary, with the definition of its source in short; drivers look words up here, and
//! docs/measured/cycle-boundaries.md prints the tables with what comes of them.

use trunnion_core::reading::Execution;

/// A word or number of a vocabulary.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// As the controller gives it; upper or lower case.
    pub word: &'static str,
    /// What it means here.
    pub means: Execution,
    /// What the source says of it, in short.
    pub definition: &'static str,
}

/// The words of one kind of controller.
#[derive(Clone, Copy, Debug)]
pub struct Vocabulary {
    /// Whose words they are.
    pub name: &'static str,
    /// Where they are defined.
    pub source: &'static str,
    /// All of them.
    pub words: &'static [Word],
}

impl Vocabulary {
    /// What a word means; a word that is not in the table says nothing.
    pub fn execution(&self, word: &str) -> Execution {
        let known = self.words.iter().find(|known| known.word.eq_ignore_ascii_case(word));
        known.map_or(Execution::Unknown, |known| known.means)
    }
}

/// Every vocabulary.
pub const VOCABULARIES: [&Vocabulary; 5] = [&MTCONNECT, &SINUMERIK, &OPC_40502, &OPC_UA_TEXT, &LINUXCNC];

const fn word(word: &'static str, means: Execution, definition: &'static str) -> Word {
    Word { word, means, definition }
}

/// `EXECUTION` of MTConnect.
pub const MTCONNECT: Vocabulary = Vocabulary {
    name: "MTConnect `EXECUTION`",
    source: "[MTConnect], enumeration Execution",
    words: &[
        word("READY", Execution::Ready, "ready to execute, idle"),
        word("ACTIVE", Execution::Active, "executes an instruction"),
        word("INTERRUPTED", Execution::Held, "suspended by an external signal; an action resumes it"),
        word("FEED_HOLD", Execution::Held, "the axes are commanded to stop where they are"),
        word(
            "OPTIONAL_STOP",
            Execution::Held,
            "interrupted by a command of the program that can be ignored (M1)",
        ),
        word("PROGRAM_OPTIONAL_STOP", Execution::Held, "the same, before version 1.4"),
        word(
            "PROGRAM_STOPPED",
            Execution::Held,
            "interrupted by a command of the program (M0); an action resumes it",
        ),
        word("WAIT", Execution::Held, "suspended while a secondary operation executes; resumes by itself"),
        word("STOPPED", Execution::Stopped, "the program is not ready to execute"),
        word("PROGRAM_COMPLETED", Execution::Ended, "the program completed execution"),
    ],
};

/// `progStatus` of SINUMERIK. Programs of others read 2 and 3 so too; 1, 4 and 5 are not confirmed.
pub const SINUMERIK: Vocabulary = Vocabulary {
    name: "SINUMERIK `progStatus`",
    source: "lists of variables of the controller; 1, 4 and 5 not confirmed at a controller",
    words: &[
        word("1", Execution::Held, "interrupted"),
        word("2", Execution::Held, "stopped (NC stop, M0, M1)"),
        word("3", Execution::Active, "in progress"),
        word("4", Execution::Active, "waiting"),
        word("5", Execution::Ended, "aborted (reset; also after the end of the program)"),
    ],
};

/// `CncChannelProgramStatus` of OPC 40502.
pub const OPC_40502: Vocabulary = Vocabulary {
    name: "OPC UA `CncChannelProgramStatus`",
    source: "[OPC 40502 §7.2.5]",
    words: &[
        word("0", Execution::Ended, "stopped: regular stop of the execution"),
        word("1", Execution::Active, "running"),
        word("2", Execution::Active, "waiting (dwell, event)"),
        word("3", Execution::Held, "interrupted (M0, M1)"),
        word("4", Execution::Ended, "canceled: irregular stop of the execution"),
    ],
};

/// Words of OPC UA servers that show texts.
pub const OPC_UA_TEXT: Vocabulary = Vocabulary {
    name: "OPC UA, texts",
    source: "words of other vocabularies; no standard",
    words: &[
        word("active", Execution::Active, ""),
        word("running", Execution::Active, ""),
        word("waiting", Execution::Active, ""),
        word("interrupted", Execution::Held, ""),
        word("held", Execution::Held, ""),
        word("feed_hold", Execution::Held, ""),
        word("stopped", Execution::Stopped, ""),
        word("canceled", Execution::Ended, ""),
        word("cancelled", Execution::Ended, ""),
        word("aborted", Execution::Ended, ""),
        word("completed", Execution::Ended, ""),
        word("ready", Execution::Ready, ""),
        word("idle", Execution::Ready, ""),
        word("reset", Execution::Ready, ""),
    ],
};

/// `PROGRAM_STATUS` of linuxcncrsh.
pub const LINUXCNC: Vocabulary = Vocabulary {
    name: "LinuxCNC `PROGRAM_STATUS`",
    source: "man page linuxcncrsh(1)",
    words: &[
        word("IDLE", Execution::Ready, "no program runs: before, after, after abort or emergency stop"),
        word("RUNNING", Execution::Active, "a program runs"),
        word("PAUSED", Execution::Held, "it is held: M0, M1, pause"),
    ],
};
