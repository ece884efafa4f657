//! NC programs of measuring cycles: one file per dialect of the controllers.
//!
//! [`Program`] is the same for every dialect: straight moves of all axes with a feed or a duration, dwells, stops with a
//! word to the operator. Tool-point following (TCP, RTCP, TRAORI, M128) stays off: the program moves every axis itself, so
//! that what is measured is the machine and not the controller's model of it.

mod compose;
mod fanuc;
mod heidenhain;
mod linuxcnc;
mod program;
mod siemens;
mod words;

pub use program::{Block, Program};

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
    /// Decimals of positions in mm and degrees that such controllers usually take.
    pub decimals: usize,
    /// The text of the program; decimals of positions.
    pub write: fn(&Program, usize) -> String,
}

/// The registry.
pub static DIALECTS: [&Dialect; 4] =
    [&fanuc::DIALECT, &heidenhain::DIALECT, &linuxcnc::DIALECT, &siemens::DIALECT];

/// The dialect of this name.
pub fn dialect(name: &str) -> Option<&'static Dialect> {
    DIALECTS.into_iter().find(|dialect| dialect.name == name)
}
