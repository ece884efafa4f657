//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

mod compensation_formats;
#[path = "nc/interpreter.rs"]
mod interpreter;
mod nc_programs;
mod pages;
#[path = "nc/visited.rs"]
mod visited;
