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
    /// The text of the program; decimals of positions.
    pub write: fn(&Program, usize) -> String,
}
