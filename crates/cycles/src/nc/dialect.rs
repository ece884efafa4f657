//! What a dialect is.

use super::program::Program;

/// One dialect: plain data and a function, one constant per file.
pub struct Dialect {
    /// Name on the command line and of the file.
    pub name: &'static str,
    /// Controllers that read it.
    pub controllers: &'static str,
    /// Where the syntax is described.
    pub source: &'static str,
    /// Usual ending of the file name.
    pub ending: &'static str,
    /// How it gives the duration of a block, for the guide.
    pub duration: &'static str,
    /// How it dwells.
    pub dwell: &'static str,
    /// How it stops with a word to the operator.
    pub stop: &'static str,
    /// Decimals of positions in mm and degrees that such controllers usually take.
    pub decimals: usize,
    /// True where a program has a number, under which the control keeps it.
    pub numbered: bool,
    /// Its tool centre point control; `None` where it has none.
    pub tool_point: Option<ToolPoint>,
    /// The text of the program; decimals of positions.
    pub write: fn(&Program, usize) -> String,
}

/// Tool centre point control of a dialect.
pub struct ToolPoint {
    /// What switches it on, for the guide.
    pub name: &'static str,
    /// What the operator checks on such controls.
    pub check: &'static str,
    /// Where it is described.
    pub source: &'static str,
}

impl Dialect {
    /// What the operator reads before starting: of every control, and of this one.
    pub(super) fn header(&self, program: &Program) -> Vec<String> {
        let own = self.tool_point.as_ref().filter(|_| program.tool_point);
        program.header.iter().cloned().chain(own.map(|own| format!("6. {}", own.check))).collect()
    }
}
