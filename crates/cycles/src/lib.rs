//! Cycles and what they measure: cycle files, poses, courses, runs, and NC programs in the dialects of controllers.

pub mod cycle;
pub mod nc;
mod run;

pub use cycle::Cycle;
pub use cycle::course::{CourseRules, Step};
pub use cycle::visit::{Pace, VisitError, Visits};
pub use run::{Run, RunKind};
