//! The integration tests of this crate, one file per subject.

#![expect(clippy::unwrap_used, reason = "helpers of tests may panic")]

#[path = "nc/clear.rs"]
mod clear;
mod durations;
#[path = "nc/interpreter.rs"]
mod interpreter;
mod nc_programs;
mod program_numbers;
#[allow(dead_code, reason = "the tests of this crate use a part")]
#[path = "../../../../tests/src/section.rs"]
mod section;
#[path = "nc/visited.rs"]
mod visited;
