//! NC programs of measuring cycles: one file per dialect of the controllers.
//!
//! [`Program`] is the same for every dialect: straight moves of all axes with a feed or a duration, dwells, stops with a
//! word to the operator. Tool-point following (TCP, RTCP, TRAORI, M128) stays off: the program moves every axis itself, so
//! that what is measured is the machine and not the controller's model of it. Where that model is what is measured, as a correction that
//! acts in it, `CourseRules::tool_point` switches it on.

mod compose;
mod dialect;
mod fanuc;
mod heidenhain;
mod linuxcnc;
mod program;
mod siemens;
mod tool_point;
mod words;

pub use dialect::{Dialect, ToolPoint};

pub use program::{Block, Program, whole_minutes};

/// The registry.
pub static DIALECTS: &[&Dialect] =
    &[&fanuc::DIALECT, &heidenhain::DIALECT, &linuxcnc::DIALECT, &siemens::DIALECT];

/// The dialect of this name.
pub fn dialect(name: &str) -> Option<&'static Dialect> {
    DIALECTS.iter().copied().find(|dialect| dialect.name == name)
}
