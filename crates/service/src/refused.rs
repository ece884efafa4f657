//! Why no cycle is measured for what the controller runs or the operator chose.

use trunnion_core::names::allowed;

/// No cycle for what the controller runs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// No `[[program]]` is like it.
    #[error("no [[program]] of the configuration is named like \"{program}\"; allowed: {allowed}")]
    Program {
        /// The program.
        program: String,
        /// What would have been measured.
        allowed: String,
    },
    /// No `[[program]]` has the number of the signal.
    #[error("no [[program]] of the configuration has signal = {signal}; allowed: {allowed}")]
    Signal {
        /// The number.
        signal: u32,
        /// What would have been measured.
        allowed: String,
    },
    /// The operator chose what there is not.
    #[error("there is no cycle {chosen:?}; allowed: {allowed}")]
    Cycle {
        /// What was chosen.
        chosen: String,
        /// What could have been.
        allowed: String,
    },
    /// What was chosen is too long for a name, or no text.
    #[error("{bytes} bytes came in place of the name of a cycle, in UTF-8 and no longer than that of a file")]
    Name {
        /// How many came.
        bytes: usize,
    },
}

impl Refused {
    /// None of these cycles is the chosen one.
    pub(crate) fn no_cycle<'a>(chosen: &str, names: impl Iterator<Item = &'a str>) -> Self {
        Self::Cycle { chosen: chosen.into(), allowed: allowed(chosen, names) }
    }
}
