//! Cycles and what they measure: cycle files, poses, courses, runs, and NC programs in the dialects of controllers.

pub mod cycle;
pub mod nc;
mod run;

pub use cycle::Cycle;
pub use run::{Run, RunKind};
